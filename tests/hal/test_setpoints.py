"""Setpoints by mode and hold law, without a simulator."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.hal.setpoints import SetpointLimits, Setpoints
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot

START = np.array([0.1, -0.3, 0.2, -2.2, 0.3, 2.0, 0.7, 0.06])
ARM = tuple(range(7))


@pytest.fixture
def robot() -> RobotManifest:
    return load_robot("panda")


@pytest.fixture
def setpoints(robot: RobotManifest) -> Setpoints:
    made = Setpoints(robot)
    made.restart(START)
    return made


def joints(mode: ControlMode, values: dict[int, float]) -> PartCommand:
    row = np.zeros(8)
    row[list(values)] = list(values.values())
    return PartCommand(mode, "", row, tuple(values))


def opening(value: float) -> PartCommand:
    return PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([value]), ())


def follow(setpoints: Setpoints, **commands: PartCommand) -> FloatArray:
    """One period of a robot that follows at once."""
    return setpoints.advance(commands, setpoints.positions.copy())


def changed(robot: RobotManifest, part: int, **fields: object) -> RobotManifest:
    data = yaml.safe_load(Path(robot_dir("panda") / "robot.yaml").read_text(encoding="utf-8"))
    data["parts"][part] |= fields
    if "modes" in fields:
        limits = data["safety"]["sim"]["parts"][data["parts"][part]["name"]]
        tool = {"transitions": limits["transitions"]}
        limits.clear()
        limits["composite_mode"] = {
            "step_limit": 1.0, "switching": "anywhere", "source": "test",
        }  # fmt: skip
        if fields["modes"] == ["body_twist"]:
            limits.clear()
            limits["body_twist"] = {
                "frames": ["base_link"], "linear_limit_m_s": 1.0, "angular_limit_rad_s": 1.0,
                "linear_step_limit_m_s": 1.0, "angular_step_limit_rad_s": 1.0,
                "gain": [0.0, 1.0], "linear_tracking_m_s": 1.0, "angular_tracking_rad_s": 1.0,
                "free_axes": [0], "source": "test",
            }  # fmt: skip
        if fields["modes"] == ["gripper_binary"]:
            limits.clear()
            limits["gripper_binary"] = {"source": "test"}
        limits.update(tool)
    return RobotManifest.model_validate(data)


def test_position_commands_are_taken_as_they_are_and_only_by_active_joints(
    setpoints: Setpoints,
) -> None:
    after = follow(setpoints, arm=joints(ControlMode.JOINT_POSITION, {1: -0.25, 6: 0.75}))
    np.testing.assert_array_equal(after, [0.1, -0.25, 0.2, -2.2, 0.3, 2.0, 0.75, 0.06])


def test_velocity_commands_move_active_joints_by_rate_times_period(setpoints: Setpoints) -> None:
    after = follow(setpoints, arm=joints(ControlMode.JOINT_VELOCITY, {0: 1.0, 3: -0.4}))
    np.testing.assert_allclose(after - START, [0.05, 0, 0, -0.02, 0, 0, 0, 0], atol=1e-12)


def test_velocity_ends_at_the_position_limit(setpoints: Setpoints, robot: RobotManifest) -> None:
    for _ in range(60):
        follow(setpoints, arm=joints(ControlMode.JOINT_VELOCITY, {3: 2.0}))
    assert setpoints.positions[3] == robot.joint("panda_joint4").upper


def test_a_blocked_joint_is_led_by_two_periods_of_full_speed_at_most(
    setpoints: Setpoints, robot: RobotManifest
) -> None:
    push = {"arm": joints(ControlMode.JOINT_VELOCITY, {0: 1.0})}
    for _ in range(60):
        setpoints.advance(push, START)
    lead = 2 * robot.joint("panda_joint1").velocity_limit * 0.05
    np.testing.assert_allclose(setpoints.positions[0] - START[0], lead, atol=1e-12)


def test_targets_that_lead_a_blocked_joint_come_back_to_that_once_when_its_part_holds(
    setpoints: Setpoints, robot: RobotManifest
) -> None:
    lead = 2 * robot.joint("panda_joint1").velocity_limit * 0.05
    targets = START[:7] + np.array([0.5, -0.5, 0.1, 0.0, 0.0, 0.0, 0.0])
    setpoints.advance({"arm": joints(ControlMode.JOINT_POSITION, dict(enumerate(targets)))}, START)
    wanted = START + np.array([lead, -lead, 0.1, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(setpoints.advance({}, START), wanted, atol=1e-12)
    sunk = START - 1.0  # a hold never goes after the joints
    np.testing.assert_allclose(setpoints.advance({}, sunk), wanted, atol=1e-12)


def test_a_gripper_that_closes_on_something_goes_on_pressing(setpoints: Setpoints) -> None:
    for _ in range(20):
        setpoints.advance({"gripper": opening(0.0)}, START)
    np.testing.assert_allclose(setpoints.advance({}, START), [*START[:7], 0.0], atol=1e-12)


def test_a_part_that_somebody_else_has_moved_goes_on_from_there(setpoints: Setpoints) -> None:
    follow(setpoints, arm=joints(ControlMode.JOINT_VELOCITY, {0: 1.0}), gripper=opening(0.0))
    moved = START + 0.5
    setpoints.stand_at("arm", moved)
    after = setpoints.advance({"arm": joints(ControlMode.JOINT_POSITION, {1: 0.2})}, moved)
    np.testing.assert_array_equal(after[[0, *range(2, 7)]], moved[[0, *range(2, 7)]])
    assert after[1] == 0.2 and after[7] < START[7], "the gripper is another part"


def test_a_tools_motion_moves_no_joint_at_its_speed_limit(robot: RobotManifest) -> None:
    limits, joints = SetpointLimits(robot), [0, 1]
    steps = np.array([2.0, -0.5]) * limits.reach[joints]
    scale = limits.step_scale(joints, steps, np.zeros(2), np.zeros(2))
    assert 0.9 * limits.reach[0] < scale * steps[0] < 0.98 * limits.reach[0]


def test_a_gripper_travels_below_its_speed_limit_and_stops_at_the_command(
    setpoints: Setpoints,
) -> None:
    first = follow(setpoints, gripper=opening(0.02))
    np.testing.assert_allclose(first[7], 0.06 - 0.9 * 0.005, atol=1e-12)
    for _ in range(10):
        last = follow(setpoints, gripper=opening(0.02))
    np.testing.assert_allclose(last, [*START[:7], 0.02], atol=1e-12)


def test_what_was_not_told_leaves_no_trace(setpoints: Setpoints, robot: RobotManifest) -> None:
    """Targets, velocities and an opening on its way are as before; a lead comes back once more."""
    other = Setpoints(robot)
    other.restart(START)
    told = {"arm": joints(ControlMode.JOINT_POSITION, {0: 0.5}), "gripper": opening(0.0)}
    for one in (setpoints, other):
        one.advance(told, START)
    setpoints.advance({}, START)  # of which the robot heard nothing
    setpoints.undo()
    for _ in range(20):
        np.testing.assert_array_equal(setpoints.advance({}, START), other.advance({}, START))


def test_keep_position_leaves_the_setpoint_also_after_a_velocity(setpoints: Setpoints) -> None:
    before = follow(setpoints, arm=joints(ControlMode.JOINT_VELOCITY, {0: 2.0}))
    for _ in range(5):
        setpoints.advance({}, START)
    np.testing.assert_array_equal(setpoints.positions, before)


def test_keep_command_lets_a_gripper_finish_its_way(setpoints: Setpoints) -> None:
    follow(setpoints, gripper=opening(0.0))
    for _ in range(20):
        follow(setpoints)
    np.testing.assert_allclose(setpoints.positions[7], 0.0, atol=1e-12)


def test_ramp_to_zero_slows_down_by_the_acceleration_limit(robot: RobotManifest) -> None:
    setpoints = Setpoints(changed(robot, 0, hold="ramp_to_zero"))
    setpoints.restart(START)
    follow(setpoints, arm=joints(ControlMode.JOINT_VELOCITY, {0: 2.0, 1: -0.3}))
    steps = []
    for _ in range(4):
        before = setpoints.positions.copy()
        steps.append(follow(setpoints)[:2] - before[:2])
    # 15 rad/s2 and 7.5 rad/s2 over 50 ms: 0.75 and 0.375 rad/s less each period
    expected = np.array([[1.25, 0], [0.5, 0], [0, 0], [0, 0]]) * 0.05
    np.testing.assert_allclose(steps, expected, atol=1e-12)


def test_a_new_episode_forgets_targets_and_velocities(setpoints: Setpoints) -> None:
    follow(setpoints, gripper=opening(0.0), arm=joints(ControlMode.JOINT_VELOCITY, {0: 2.0}))
    setpoints.restart(START)
    np.testing.assert_array_equal(follow(setpoints), START)


def test_a_binary_gripper_travels_to_an_end_of_its_range(robot: RobotManifest) -> None:
    setpoints = Setpoints(changed(robot, 1, modes=["gripper_binary"]))
    setpoints.restart(START)
    closed = PartCommand(ControlMode.GRIPPER_BINARY, "", np.array([1.0]), ())
    opened = PartCommand(ControlMode.GRIPPER_BINARY, "", np.array([0.0]), ())
    np.testing.assert_allclose(follow(setpoints, gripper=closed)[7], 0.06 - 0.9 * 0.005, atol=1e-12)
    for _ in range(20):
        follow(setpoints)  # held: it goes on to where it was told to be
    assert setpoints.positions[7] == 0.0
    for _ in range(20):
        follow(setpoints, gripper=opened)
    assert setpoints.positions[7] == 0.08


@pytest.mark.parametrize(
    ("part", "fields", "text"),
    [
        (0, {"modes": ["body_twist"]},
         "hal: part arm: expected a mode of this HAL, got body_twist "
         "(valid: joint_position, joint_velocity, cartesian_pose, "
         "cartesian_delta, cartesian_twist, gripper_binary, gripper_position, "
         "dex_hand_joint, composite_mode)"),
        (0, {"hold": "write_default"},
         "hal: part arm: expected a hold law for joints, got write_default "
         "(valid: keep_position, zero_delta, ramp_to_zero, keep_command)"),
    ],
)  # fmt: skip
def test_a_robot_that_position_servos_cannot_follow_is_refused(
    robot: RobotManifest, part: int, fields: dict[str, object], text: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        Setpoints(changed(robot, part, **fields))
    assert str(caught.value) == text


def test_composite_mode_is_accepted_and_does_nothing(robot: RobotManifest) -> None:
    setpoints = Setpoints(changed(robot, 0, modes=["composite_mode"]))
    setpoints.restart(START)
    switch = PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([1.0]), ())
    np.testing.assert_array_equal(follow(setpoints, arm=switch), START)
