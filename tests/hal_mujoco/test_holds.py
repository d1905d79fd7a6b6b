"""What a part does once nothing, or something else, is commanded, and how it comes back."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.hal.setpoints import Setpoints
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.hal_mujoco.dual_panda import DualPanda, tool_row

START_M, PERIOD_S = 0.04, 0.05
ARM, GRIPPER = "right_arm", "left_gripper"


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("dual_panda")


def changed(robot: RobotManifest, part: str, **fields: object) -> RobotManifest:
    parts = [p.model_copy(update=fields) if p.name == part else p for p in robot.parts]
    return robot.model_copy(update={"parts": tuple(parts)})


def joint_row(robot: RobotManifest, mode: ControlMode, values: dict[str, float]) -> PartCommand:
    row, active = np.zeros(robot.n_dof), [robot.joint_names.index(name) for name in values]
    row[active] = list(values.values())
    return PartCommand(mode, "", row, tuple(active))


def closed() -> PartCommand:
    return PartCommand(ControlMode.GRIPPER_BINARY, "", np.array([1.0]), ())


class Followed:
    """Setpoints of a robot that follows at once, from the middle of its gripper's range."""

    def __init__(self, robot: RobotManifest, start: dict[str, float]) -> None:
        self.robot, self.setpoints = robot, Setpoints(robot)
        positions = np.zeros(robot.n_dof)
        for name, value in start.items():
            positions[robot.joint_names.index(name)] = value
        self.setpoints.restart(positions)

    def run(self, commands: dict[str, PartCommand], ticks: int = 1) -> None:
        for _ in range(ticks):
            self.setpoints.advance(commands, self.setpoints.positions.copy())

    def at(self, joint: str) -> float:
        return float(self.setpoints.positions[self.robot.joint_names.index(joint)])


@pytest.mark.parametrize("mode", ["joint_position", "joint_velocity", "composite_mode"])
def test_another_mode_makes_a_gripper_forget_its_target(robot: RobotManifest, mode: str) -> None:
    modes = ("gripper_binary", mode)
    gripper = Followed(changed(robot, GRIPPER, modes=modes), {GRIPPER: START_M})
    gripper.run({GRIPPER: closed()})
    before = gripper.at(GRIPPER)
    other = joint_row(robot, ControlMode[mode.upper()], {GRIPPER: before})
    if mode == "composite_mode":
        other = PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([1.0]), ())
    gripper.run({GRIPPER: other})
    left_at = gripper.at(GRIPPER)
    assert left_at >= before > 0.0
    gripper.run({}, 20)
    assert gripper.at(GRIPPER) == left_at


@pytest.mark.parametrize("law", ["keep_position", "zero_delta", "ramp_to_zero"])
def test_only_keep_command_lets_a_gripper_travel_on(robot: RobotManifest, law: str) -> None:
    gripper = Followed(changed(robot, GRIPPER, hold=law), {GRIPPER: START_M})
    gripper.run({GRIPPER: closed()})
    before = gripper.at(GRIPPER)
    assert 0.0 < before < START_M
    gripper.run({}, 20)
    assert gripper.at(GRIPPER) == before


def test_a_held_keep_command_gripper_finishes_a_full_stroke(robot: RobotManifest) -> None:
    gripper = Followed(robot, {GRIPPER: robot.joint(GRIPPER).upper})
    gripper.run({GRIPPER: closed()})
    gripper.run({}, 20)
    assert gripper.at(GRIPPER) == robot.joint(GRIPPER).lower


def test_a_joint_outside_its_limits_comes_back_at_the_rate_it_is_told(
    robot: RobotManifest,
) -> None:
    joint, rate = "right_joint1", ControlMode.JOINT_VELOCITY
    outside = robot.joint(joint).upper + 0.3
    arm = Followed(robot, {joint: outside})
    arm.run({ARM: joint_row(robot, rate, {joint: -0.01})})
    np.testing.assert_allclose(arm.at(joint), outside - 0.01 * PERIOD_S, rtol=0, atol=1e-12)
    before = arm.at(joint)
    arm.run({ARM: joint_row(robot, rate, {joint: 1.0})})
    assert arm.at(joint) == before, "never further out"
    arm.run({ARM: joint_row(robot, rate, {joint: -1e6})})
    fastest = robot.joint(joint).velocity_limit * PERIOD_S
    np.testing.assert_allclose(arm.at(joint), before - fastest, rtol=0, atol=1e-12)


def test_a_tool_command_does_not_pull_a_joint_from_outside_at_once(robot: RobotManifest) -> None:
    world = DualPanda(robot)
    setpoints, own = world.backend._setpoints, world.joints(ARM)
    start = setpoints.positions.copy()
    start[own[0]] = robot.joint("right_joint1").upper + 0.3
    setpoints.restart(start)
    reach = np.array([robot.joints[joint].velocity_limit for joint in own]) * PERIOD_S
    for twist in ([0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, -0.5]):
        before = setpoints.positions.copy()
        setpoints.advance({ARM: tool_row(ControlMode.CARTESIAN_TWIST, twist)}, before)
        steps: FloatArray = (setpoints.positions - before)[own]
        assert np.all(np.abs(steps) <= reach * (1 + 1e-9)) and steps[0] <= 0.0, steps


@pytest.mark.parametrize("mode", [ControlMode.JOINT_VELOCITY, ControlMode.JOINT_POSITION])
@pytest.mark.parametrize(
    ("law", "steps"), [("ramp_to_zero", [1.25, 0.5, 0.0]), ("keep_position", [0.0, 0.0, 0.0])]
)
def test_joints_that_a_row_leaves_out_come_to_rest_by_the_hold_law(
    robot: RobotManifest, mode: ControlMode, law: str, steps: list[float]
) -> None:
    fast, other = "right_joint1", "right_joint2"
    arm = Followed(changed(robot, ARM, hold=law), {})
    arm.run({ARM: joint_row(robot, ControlMode.JOINT_VELOCITY, {fast: 2.0})})
    moved = []
    for _ in steps:
        before = arm.at(fast)
        arm.run({ARM: joint_row(robot, mode, {other: 0.1})})
        moved.append(arm.at(fast) - before)
    # 15 rad/s2 over 50 ms: 0.75 rad/s less each period
    np.testing.assert_allclose(moved, np.array(steps) * PERIOD_S, rtol=0, atol=1e-12)
