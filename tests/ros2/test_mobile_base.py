"""A base that turns about an axis beside its frame, in joints and in twists, without ROS 2."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead_hal_ros2.mobile_base import BaseDrive, BaseState, Odometry
from fairlead_hal_ros2.options import BaseTopics
from fairlead_hal_ros2.robot_fit import yaw_axis

ROBOT = load_robot("panda_mobile")
AXIS = np.array([-0.21, 0.05])


def odometry(x: float, y: float, yaw: float, twist: Any = (0.0, 0.0, 0.0)) -> Any:
    """What a driver says of its base frame: the twist along the base's own axes."""
    vector = SimpleNamespace
    turn = vector(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    linear, angular = vector(x=twist[0], y=twist[1], z=0.0), vector(x=0.0, y=0.0, z=twist[2])
    return SimpleNamespace(
        header=SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0)),
        child_frame_id="base_link",
        pose=vector(pose=vector(position=vector(x=x, y=y, z=0.0), orientation=turn)),
        twist=vector(twist=vector(linear=linear, angular=angular)),
    )


def state_of(message: Any) -> BaseState:
    heard = Odometry(BaseTopics(child_frame="base_link"), "base_link", AXIS)
    heard.take(message, 1.0)
    assert heard.newest is not None
    return heard.newest


def test_turning_about_the_axis_moves_no_slide() -> None:
    """The base frame circles round the axis, which stands in the map."""
    for yaw in np.linspace(-3.0, 3.0, 7):
        turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        x, y = AXIS - turn @ AXIS
        rates = 0.8 * np.array([AXIS[1], -AXIS[0], 1.0])  # of the base frame, along its axes
        state = state_of(odometry(x, y, yaw, rates))
        np.testing.assert_allclose(state.positions, [0.0, 0.0, yaw], atol=1e-12)
        np.testing.assert_allclose(state.velocities, [0.0, 0.0, 0.8], atol=1e-12)


@pytest.mark.parametrize("told", [(0.3, 0.0, 0.0), (0.1, -0.2, 0.0), (0.2, 0.1, 0.9)])
def test_joints_move_as_told_where_the_base_does_its_twist(told: tuple[float, ...]) -> None:
    drive = BaseDrive(ROBOT, "hardware", AXIS)
    row = np.zeros(ROBOT.n_dof)
    row[:3] = told
    command = PartCommand(ControlMode.JOINT_VELOCITY, "", row, (0, 1, 2))
    x, y, yaw, step_s = 0.4, -0.3, 2.0, 1e-5
    before = state_of(odometry(x, y, yaw)).positions
    ahead, left, turning = drive.advance(command, yaw)
    x += (ahead * math.cos(yaw) - left * math.sin(yaw)) * step_s
    y += (ahead * math.sin(yaw) + left * math.cos(yaw)) * step_s
    after = state_of(odometry(x, y, yaw + turning * step_s)).positions
    np.testing.assert_allclose((after - before) / step_s, told, atol=1e-4)


def test_a_base_that_is_told_nothing_slows_down_as_its_profile_says() -> None:
    drive = BaseDrive(ROBOT, "hardware", AXIS)
    row = np.zeros(6)
    row[0] = 0.3
    drive.advance(PartCommand(ControlMode.BODY_TWIST, "", row, ()), 0.0)
    assert drive.advance(None, 0.0)[0] == pytest.approx(0.275)  # 0.5 m/s2 in 50 ms


def test_commands_that_turn_against_the_yaw_are_a_simulator_s() -> None:
    np.testing.assert_array_equal(yaw_axis(ROBOT, "hardware"), [-0.21, 0.0])
    with pytest.raises(ConfigError) as caught:
        yaw_axis(ROBOT, "sim")
    assert str(caught.value) == (
        "hal_ros2: panda_mobile: safety.sim.base.command_frame: expected odom, got against_yaw"
    )
