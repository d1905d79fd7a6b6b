"""The real gate on a robot with two arms: a chunk of every mode is released, and one refused."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from bench.equipment.gate_scene import Scene
from fairlead.messages import ActionPart, GateState, Outcome
from fairlead.modes import ControlMode
from tests.gate.two_armed_scene import ROBOT, action, per_joint, tool_pose, two_armed_scene

pytestmark = pytest.mark.processes

JOINT_MODES = {
    ControlMode.JOINT_POSITION: "left_arm",
    ControlMode.JOINT_VELOCITY: "left_arm",
    ControlMode.DEX_HAND_JOINT: "right_hand",
}
"""Modes whose numbers are per joint, and a part that has each."""


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Scene]:
    scene = two_armed_scene(tmp_path / "gate")
    yield scene
    scene.close()


def outcome(scene: Scene, *parts: ActionPart) -> tuple[Outcome, int, str]:
    scene.safe.skip()
    verdict = scene.send(scene.chunk(rows=2, parts=parts))
    if verdict.outcome == Outcome.REFUSED:
        assert scene.safe.unread() == []
    else:
        assert scene.safe.wait_for(lambda m: m.verdict_id == verdict.verdict_id).horizon == 2
    return Outcome(verdict.outcome), verdict.code, verdict.part


@pytest.mark.parametrize("mode", JOINT_MODES, ids=lambda mode: mode.yaml_name)
def test_a_joint_mode_is_released_within_its_limits_and_refused_beyond(
    scene: Scene, mode: ControlMode
) -> None:
    part = JOINT_MODES[mode]
    good, jump = per_joint(scene, part, mode, 0.05), per_joint(scene, part, mode, 60.0)
    assert outcome(scene, jump)[0] == Outcome.REFUSED
    scene.next_tick()
    assert outcome(scene, good) == (Outcome.RELEASED, 0, "")


@pytest.mark.parametrize("part", ["left_arm", "right_arm"])
def test_a_pose_is_released_where_the_tool_is_and_refused_elsewhere(
    scene: Scene, part: str
) -> None:
    pose = tool_pose(scene, part)
    ahead = np.array([1.0, 0, 0, 0, 0, 0, 0])
    moved, far = pose + 0.01 * ahead, pose + 0.06 * ahead
    longer = pose * np.array([1, 1, 1, 1.01, 1.01, 1.01, 1.01])
    for rows, code in (([far, far], 21), ([longer, longer], 20)):
        poses = action(part, ControlMode.CARTESIAN_POSE, rows, "base_link")
        assert outcome(scene, poses) == (Outcome.REFUSED, code, part)
        scene.next_tick()
    poses = action(part, ControlMode.CARTESIAN_POSE, [pose, moved], "base_link")
    assert outcome(scene, poses) == (Outcome.RELEASED, 0, "")


@pytest.mark.parametrize("mode", [ControlMode.CARTESIAN_TWIST, ControlMode.CARTESIAN_DELTA])
def test_a_small_motion_of_the_tool_is_released_and_a_large_one_refused(
    scene: Scene, mode: ControlMode
) -> None:
    for size, expected in ((1.1, Outcome.REFUSED), (0.02, Outcome.RELEASED)):
        row = np.array([0.0, size, 0.0, 0.0, 0.0, 0.0])
        assert outcome(scene, action("left_arm", mode, [row, row], "base_link"))[0] == expected
        scene.next_tick()


def test_a_gripper_opens_or_closes_and_does_nothing_between(scene: Scene) -> None:
    binary = ControlMode.GRIPPER_BINARY
    half = action("left_gripper", binary, [np.array([0.5]), np.array([1.0])])
    assert outcome(scene, half) == (Outcome.REFUSED, 20, "left_gripper")
    scene.next_tick()
    switch = action("left_gripper", binary, [np.array([1.0]), np.array([0.0])])
    assert outcome(scene, switch) == (Outcome.RELEASED, 0, "")


def test_both_arms_move_in_one_chunk_or_neither_does(scene: Scene) -> None:
    left, right = tool_pose(scene, "left_arm"), tool_pose(scene, "right_arm")
    mode = ControlMode.CARTESIAN_POSE
    ours = action("left_arm", mode, [left, left], "base_link")
    swapped = action("right_arm", mode, [left, left], "base_link")
    assert outcome(scene, ours, swapped)[::2] == (Outcome.REFUSED, "right_arm")
    scene.next_tick()
    both = (ours, action("right_arm", mode, [right, right], "base_link"))
    assert outcome(scene, *both) == (Outcome.RELEASED, 0, "")


def test_a_chunk_for_one_arm_cannot_command_a_joint_of_the_other(scene: Scene) -> None:
    row = np.zeros(ROBOT.n_dof)
    other = ROBOT.joint_names.index("right_joint1")
    left = action("left_arm", ControlMode.JOINT_VELOCITY, [row, row])
    stolen = structs.replace(left, active=(*left.active, other))
    assert outcome(scene, stolen) == (Outcome.REFUSED, 9, "left_arm")


def test_no_number_at_all_stops_the_robot_in_a_pose_too(scene: Scene) -> None:
    pose = tool_pose(scene, "left_arm")
    pose[4] = np.nan
    poses = action("left_arm", ControlMode.CARTESIAN_POSE, [pose, pose], "base_link")
    assert outcome(scene, poses) == (Outcome.REFUSED, 8, "left_arm")
    scene.wait_state(GateState.STOPPED)
