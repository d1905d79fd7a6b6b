"""The wave of `skill new` fits each robot's joints: the real gate refuses none of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.paths import robot_ids
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.cli.command import fairlead_here
from tests.draft.drafting import Desk
from tests.draft.own_arms import drafted, slow_scara, straight_arm
from tests.skill.waves import waved, written_skill

pytestmark = pytest.mark.processes

MODES = ("joint_velocity", "joint_position")
SHIPPED = [
    (name, mode)
    for name in robot_ids()
    for mode in MODES
    if any(mode in part.modes for part in load_robot(name).parts if "arm" in part.name)
]


def waving(folder: Path, robot: RobotManifest, mode: str) -> str:
    """The joint that waves, as far as one can see, and no row of it refused."""
    skill = written_skill(folder / "mine", robot, mode)
    verdicts, way = waved(folder, robot, skill)
    refused = [(v.code, v.axis, v.row, v.value, v.limit) for v in verdicts if v.code]
    assert refused == []
    (moved,) = np.flatnonzero(np.ptp(way, axis=0) > 1e-6)
    joint = robot.joints[moved]
    assert np.ptp(way[:, moved]) > (0.1 if joint.unit == "rad" else 0.01)
    return joint.name


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path / "robots"))
    return Desk(tmp_path)


@pytest.mark.parametrize(("name", "mode"), SHIPPED)
def test_the_gate_lets_a_new_wave_of_joints_pass_on_every_shipped_robot(
    name: str, mode: str, tmp_path: Path
) -> None:
    assert waving(tmp_path, load_robot(name), mode)


@pytest.mark.parametrize(
    ("mode", "unit"),
    [("joint_velocity", "# rad/s, of lift in m/s"), ("joint_position", "in rad, of lift in m.")],
)
def test_a_short_slow_sliding_joint_waves_within_its_range_in_its_own_unit(
    mode: str, unit: str, desk: Desk
) -> None:
    robot = drafted(desk, "scara", slow_scara(-0.03))
    assert waving(desk.folder, robot, mode) == "lift"
    assert unit in (desk.folder / "mine" / "rskill.yaml").read_text()


@pytest.mark.parametrize("mode", MODES)
def test_another_joint_waves_where_the_sliding_ones_home_is_an_end_stop(
    mode: str, desk: Desk
) -> None:
    assert waving(desk.folder, drafted(desk, "scara", slow_scara(0.0)), mode) == "bend"


def test_where_the_tool_is_singular_at_home_a_new_skill_waves_a_joint(desk: Desk) -> None:
    robot = drafted(desk, "straight", straight_arm())
    assert robot.part("arm").modes[-1] == "cartesian_delta"
    assert waving(desk.folder, robot, "") == "bend"


def test_check_warns_of_a_skill_that_moves_a_tool_from_a_singular_home(desk: Desk) -> None:
    robot = drafted(desk, "straight", straight_arm())
    for mode, warned in (("cartesian_delta", True), ("joint_position", False)):
        written_skill(desk.folder / mode, robot, mode)
        done = fairlead_here("skill", "check", str(desk.folder / mode), state=desk.folder)
        said = "WARNING home is singular for the tool of arm: smallest singular value "
        assert (done.returncode, said in done.stdout) == (0, warned), done.stdout + done.stderr
