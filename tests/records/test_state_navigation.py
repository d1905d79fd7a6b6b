"""Navigation and a policy on one robot, at once and one after the other."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from fairlead.messages import GoalResult, Hold, JointState, decode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.robot.manifest import load_robot
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead
from tests.system.mode_robot import ModeSkill, write_skills

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"
ROBOT = load_robot("panda_mobile")
ARM, BASE = (ROBOT.part_names.index(name) for name in ("arm", "base"))
DELTA = {
    "control_mode": "cartesian_delta", "ee": "gripper", "frame": "base_link",
    "scale": [0.05, 0.05, 0.05, 0.5, 0.5, 0.5],
}  # fmt: skip
WIGGLE = ModeSkill((DELTA,), ((0.0, 0.0, 0.02, 0.0, 0.0, 0.0),))


@pytest.fixture
def two_runners(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ScratchRobot]:
    write_skills(tmp_path / "skills", {"wiggle": WIGGLE}, ROBOT, {"layout": "libero", "dim": 9})
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path / "skills"))
    scratch = make_scratch(SOURCE, tmp_path / "state", ScratchOptions(hal=LIGHT_HAL))
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as running:
        yield running


def test_state_34_the_base_navigates_while_a_policy_moves_the_arm(
    two_runners: ScratchRobot,
) -> None:
    """Two runners move base and arm in the same ticks."""
    client = two_runners.client
    states: list[JointState] = []
    ended: list[GoalResult | None] = []
    client.bus.subscribe(client.keys.joints, lambda s: states.append(decode(JointState, s.payload)))

    def together() -> list[int]:
        return [s.tick for s in states if {s.acted[p].hold for p in (ARM, BASE)} == {Hold.NONE}]

    def manipulate() -> None:
        ended.append(run_goal(client, GoalOptions("wiggle", deadline_ticks=0)).result)

    client.arm()
    threading.Thread(target=manipulate, daemon=True).start()
    wait_for(
        lambda: any(s.acted[ARM].hold == Hold.NONE for s in states), "the policy moves the arm"
    )
    drove: GoalResult | None = run_goal(client, GoalOptions("go-to", "0.3 0.1 0")).result
    assert drove is not None and drove.outcome == "succeeded", drove
    assert not ended and len(together()) > 10
    client.cancel("manipulation", client.goal_feedback("manipulation").goal_id)
    wait_for(lambda: bool(ended), "the policy's goal ends")


@pytest.mark.simulator
@pytest.mark.thorough
def test_state_35_navigation_then_manipulation_is_one_command(
    tmp_path: Path,
) -> None:
    """Driving, then picking, is one command."""
    scratch = make_scratch(SOURCE, tmp_path / "state", ScratchOptions())
    expert = "oracle-counter-to-cabinet"
    words = ["run", "go-to", "--seed", "0", "--prompt", "0.05 0.15 0", "--then", expert]
    with scratch_robot(scratch, Registry(tmp_path / "registry")):
        done = fairlead(
            *words, "--deployment", str(scratch.file), state=scratch.state_dir / "registry"
        )
    assert done.returncode == 0, done.stdout + done.stderr
    drove, placed = done.stdout.splitlines()
    assert drove.startswith("go-to succeeded after ")
    assert "(decided by the policy): the base is at 0.0" in drove
    assert placed.startswith(f"{expert} succeeded after ")
    assert placed.endswith("(decided by the task)")
