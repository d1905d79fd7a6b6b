"""Do the options fit the robot? Asked once, before anything is opened."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.setpoints import check_command_frame
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead_hal_ros2.options import Ros2Options

POSITION_MODES = (
    ControlMode.JOINT_POSITION,
    ControlMode.JOINT_VELOCITY,
    ControlMode.DEX_HAND_JOINT,
    ControlMode.GRIPPER_POSITION,
    ControlMode.GRIPPER_BINARY,
)
BASE_MODES = (ControlMode.JOINT_VELOCITY, ControlMode.BODY_TWIST)


def yaw_axis(robot: RobotManifest, profile: str) -> FloatArray:
    """Where a mobile base turns, in its own frame [m]; shape ``[2]``.

    Raises:
        ConfigError: commands of a simulator's base, which no twist follows.
    """
    check_command_frame(robot, profile, "hal_ros2")
    base = robot.profile(profile).base
    return np.zeros(2) if base is None else np.array(base.yaw_axis_m)


def check_fit(robot: RobotManifest, profile: str, options: Ros2Options) -> None:
    """Compare names and modes.

    Raises:
        ConfigError: with every option that does not fit.
    """
    problems = list(_problems(robot, options))
    timeout_s = robot.profile(profile).protocol.state_timeout_ms / 1000.0
    if profile == "hardware" and options.stale_after_s > timeout_s:
        what = f"at most the profile's state_timeout_ms, {timeout_s:g} s: after that the gate stops"
        problems.append(expected("stale_after_s", what, options.stale_after_s))
    if problems:
        raise ConfigError(f"hal_ros2: {len(problems)} problem(s):\n  " + "\n  ".join(problems))


def _problems(robot: RobotManifest, options: Ros2Options) -> Iterator[str]:
    yield from _unknown("joints", options.joints, robot.measured_joint_names)
    yield from _unknown("without_effort", options.without_effort, robot.measured_joint_names)
    base = _base_part(robot)
    driven = [part for part in robot.parts if part.joints and part is not base]
    yield from _unknown("parts", options.parts, [part.name for part in driven])
    for part in driven:
        if part.name not in options.parts:
            yield f"parts: expected the topic of part {part.name}, got none"
        yield from _modes(part, POSITION_MODES)
    for joint, factors in options.joints.items():
        if not all(factors.values()):
            yield expected(f"joints.{joint}", "factors other than 0", factors)
    if base is None and options.base is not None:
        yield f"base: expected none, for robot {robot.id} has no base_joints"
    if base is not None:
        if options.base is None:
            yield f"base: expected the topics of part {base.name}, got none"
        if len(robot.base_joints) != 3:
            yield expected("base", "base_joints x, y and yaw in robot.yaml", robot.base_joints)
        yield from _modes(base, BASE_MODES)
        for name in (one for one in robot.base_joints if one not in options.without_effort):
            yield f"without_effort: expected joint {name} in it, for odometry has no efforts"


def _base_part(robot: RobotManifest) -> Part | None:
    return robot.owner(robot.base_joints[0]) if robot.base_joints else None


def _unknown(option: str, given: Iterable[str], valid: Iterable[str]) -> Iterator[str]:
    known = list(valid)
    for name in given:
        if name not in known:
            yield expected(option, "a name in robot.yaml", repr(name), known)


def _modes(part: Part, valid: tuple[ControlMode, ...]) -> Iterator[str]:
    for mode in part.control_modes:
        if mode not in valid:
            names = (one.yaml_name for one in valid)
            yield expected(f"part {part.name}", "modes of this HAL", mode.yaml_name, names)
