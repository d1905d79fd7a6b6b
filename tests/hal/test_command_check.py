"""What a row must be for the part it is for: the host's last look, before a backend gets it."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.hal.backend import CommandCheck, PartCommand
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot

ARM = tuple(range(7))


def row(
    mode: ControlMode, values: Sequence[float], frame: str = "", active: tuple[int, ...] = ()
) -> PartCommand:
    return PartCommand(mode, frame, np.array(values, dtype=float), active)


@pytest.mark.parametrize(
    ("part", "command", "text"),
    [
        ("arm", row(ControlMode.GRIPPER_POSITION, [0.0]),
         "hal: part arm: expected a mode, got gripper_position "
         "(valid: joint_position, joint_velocity)"),
        ("arm", row(ControlMode.JOINT_POSITION, [0.0] * 7, active=ARM),
         "hal: part arm: expected 8 value(s) of joint_position, got shape [7]"),
        ("gripper", row(ControlMode.GRIPPER_POSITION, [0.0] * 2),
         "hal: part gripper: expected 1 value(s) of gripper_position, got shape [2]"),
        ("arm", row(ControlMode.JOINT_POSITION, [0.0] * 8, active=(0, 7)),
         "hal: part arm: expected active joints out of [0, 1, 2, 3, 4, 5, 6], got [0, 7]"),
        ("gripper", row(ControlMode.GRIPPER_POSITION, [np.nan]),
         "hal: part gripper: expected finite values, got [nan]"),
        ("leg", row(ControlMode.GRIPPER_POSITION, [0.0]),
         "robot panda: expected a part, got 'leg' (valid: arm, gripper)"),
    ],
)  # fmt: skip
def test_a_command_that_does_not_fit_its_part_is_refused(
    part: str, command: PartCommand, text: str
) -> None:
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
        CommandCheck(load_robot("panda"), "sim").check(part, command)


@pytest.mark.parametrize(
    ("command", "text"),
    [
        (row(ControlMode.CARTESIAN_DELTA, [0.0] * 5, "base_link"),
         "expected 6 value(s) of cartesian_delta, got shape [5]"),
        (row(ControlMode.CARTESIAN_DELTA, [0.0] * 6, "left_tcp"),
         "expected a frame of cartesian_delta, got 'left_tcp' (valid: base_link)"),
        (row(ControlMode.CARTESIAN_TWIST, [0.0] * 6),
         "expected a frame of cartesian_twist, got '' (valid: base_link)"),
        (row(ControlMode.CARTESIAN_POSE, [0.5, 0.0, 0.9, 0.0, 0.0, 0.0, 0.99], "base_link"),
         "expected a quaternion of length 1, got length 0.99"),
        (row(ControlMode.CARTESIAN_TWIST, [0, np.inf, 0, 0, 0, 0], "base_link"),
         "expected finite values, got [0.0, inf, 0.0, 0.0, 0.0, 0.0]"),
        (row(ControlMode.BODY_TWIST, [0.0] * 6, "base_link"),
         "expected a mode, got body_twist (valid: joint_position, "
         "joint_velocity, cartesian_pose, cartesian_delta, cartesian_twist)"),
    ],
)  # fmt: skip
def test_a_tool_row_that_does_not_fit_is_refused(command: PartCommand, text: str) -> None:
    with pytest.raises(ConfigError, match=f"^hal: part right_arm: {re.escape(text)}$"):
        CommandCheck(load_robot("dual_panda"), "sim").check("right_arm", command)


@pytest.mark.parametrize(
    ("part", "command", "text"),
    [
        ("base", row(ControlMode.BODY_TWIST, [0.0] * 5, "base_link"),
         "expected 6 value(s) of body_twist, got shape [5]"),
        ("base", row(ControlMode.JOINT_VELOCITY, [0.0] * 3, active=(0, 1, 2)),
         "expected 11 value(s) of joint_velocity, got shape [3]"),
        ("base", row(ControlMode.JOINT_VELOCITY, [0.1] + [0.0] * 10, active=(0, 5)),
         "expected active joints out of [0, 1, 2], got [0, 5]"),
        ("arm", row(ControlMode.BODY_TWIST, [0.0] * 6, "base_link"),
         "expected a mode, got body_twist (valid: cartesian_delta)"),
    ],
)  # fmt: skip
def test_a_row_of_a_mobile_robot_that_does_not_fit_is_refused(
    part: str, command: PartCommand, text: str
) -> None:
    with pytest.raises(ConfigError, match=f"^hal: part {part}: {re.escape(text)}$"):
        CommandCheck(load_robot("panda_mobile"), "sim").check(part, command)


def test_a_command_that_fits_passes() -> None:
    check = CommandCheck(load_robot("dual_panda"), "sim")
    check.check("right_arm", row(ControlMode.CARTESIAN_DELTA, [0.0] * 6, "base_link"))
