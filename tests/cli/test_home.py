"""``fairlead home`` moves joints to where they rest, and says which it left where they are."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import floats
from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead.robot.rules import HomePose
from fairlead_tools.cli import jog
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.cli.command import fairlead_here as fairlead

KINOVA = load_robot("kinova3")
BOUNDED = [joint.name for joint in (*KINOVA.joints, *KINOVA.passive_joints) if joint.has_bounds]
HOME = HomePose(positions=dict.fromkeys(BOUNDED, 0.5), source="test")


def test_joints_without_a_home_stay_where_they_are_and_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []
    chosen = SimpleNamespace(robot="kinova3", profile="sim")
    monkeypatch.setattr(jog, "choose_deployment", lambda _: chosen)
    monkeypatch.setattr(jog, "load_robot", lambda _: KINOVA.model_copy(update={"home": HOME}))
    monkeypatch.setattr(jog, "_hand", lambda *_: nullcontext())
    monkeypatch.setattr(jog, "_go", lambda _, wanted, __: asked.append(wanted(np.arange(7.0))))
    jog.home_command(deployment=Path("any.yaml"))
    np.testing.assert_array_equal(asked, [[0.0, 0.5, 2.0, 0.5, 4.0, 0.5, 6.0]])
    assert capsys.readouterr().out == (
        "arm is home but for joint_1, joint_3, joint_5, joint_7: without a home in robot.yaml, "
        "left where it was\n"
    )


@pytest.mark.processes
@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    ("name", "joint"),
    [("panda", "panda_joint4"), ("dual_panda", "right_joint4"), ("kinova3", "joint_4")],
)
def test_a_shipped_deployments_robot_goes_home_after_a_joint_was_jogged(
    name: str, joint: str, tmp_path: Path
) -> None:
    robot = load_robot(name)
    scratch = make_scratch(
        repo_root() / "compose" / f"{name}_mujoco.yaml", tmp_path / "state", ScratchOptions()
    )
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as running:

        def do(*words: str) -> float:
            where = ("--deployment", str(scratch.file))
            done = fairlead(words[0], *where, *words[1:], state=tmp_path)
            assert done.returncode == 0, done.stderr
            with running.client.joint_states(queue=1) as states:
                state = states.next(5.0)
            assert state is not None
            return float(floats(state.positions)[robot.joint_names.index(joint)])

        jogged_rad, home_rad = do("jog", joint, "10deg"), do("home")
    assert robot.home is not None
    rest_rad = robot.home.positions[joint]
    assert jogged_rad > rest_rad + 0.1  # an episode starts within 0.05 rad of home
    assert home_rad == pytest.approx(rest_rad, abs=2e-3)
