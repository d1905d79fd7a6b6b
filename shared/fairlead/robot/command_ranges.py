"""The range of every value a part may be told in a mode, as its robot declares it.

A norm is spread evenly over three axes, so that all of them may be at their ends at once. A joint
that turns without end may be told any number that the gate takes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fairlead.modes import ControlMode
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import MOST, ModeLimits
from fairlead.robot.part import Part

Values = NDArray[np.float64]


def command_range(
    robot: RobotManifest, part: Part, mode: ControlMode, limits: ModeLimits
) -> tuple[Values, Values]:
    """Lower and upper ends in SI, one per value: a part's joints in its order, else axes.

    Args:
        limits: the part's limits in the safety profile that holds.
    """
    joints = [robot.joint(name) for name in part.joints]
    if mode in (ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT):
        return (
            np.array([joint.lower if joint.has_bounds else -MOST for joint in joints]),
            np.array([joint.upper if joint.has_bounds else MOST for joint in joints]),
        )
    if mode is ControlMode.CARTESIAN_POSE and limits.cartesian_pose is not None:
        box = limits.cartesian_pose
        return np.array([*box.lower_m, *[-1.0] * 4]), np.array([*box.upper_m, *[1.0] * 4])
    if mode is ControlMode.GRIPPER_POSITION and limits.gripper_position is not None:
        grip = limits.gripper_position
        return np.array([grip.lower]), np.array([grip.upper])
    if mode is ControlMode.GRIPPER_BINARY:
        return np.zeros(1), np.ones(1)
    upper = _largest(joints, mode, limits)
    return -upper, upper


def norm_limits(mode: ControlMode, limits: ModeLimits) -> tuple[tuple[float, str], ...]:
    """The norms that bound a tool's delta or twist, linear then angular, each with its unit."""
    if mode is ControlMode.CARTESIAN_DELTA and limits.cartesian_delta is not None:
        delta = limits.cartesian_delta
        return (delta.linear_limit_m, "m"), (delta.angular_limit_rad, "rad")
    if mode is ControlMode.CARTESIAN_TWIST and limits.cartesian_twist is not None:
        twist = limits.cartesian_twist
        return (twist.linear_limit_m_s, "m/s"), (twist.angular_limit_rad_s, "rad/s")
    return ()


def _largest(joints: list[Joint], mode: ControlMode, limits: ModeLimits) -> Values:
    """The largest size of each value of a mode that means the same both ways."""
    if mode is ControlMode.JOINT_VELOCITY:
        return np.array([joint.velocity_limit for joint in joints])
    norms = norm_limits(mode, limits)
    if norms:
        return np.repeat([norm for norm, _ in norms], 3) / math.sqrt(3.0)
    if mode is ControlMode.BODY_TWIST and limits.body_twist is not None:
        body = limits.body_twist
        each = np.repeat([body.linear_limit_m_s, body.angular_limit_rad_s], 3)
        return np.where(np.isin(np.arange(6), body.free_axes), each, 0.0)
    return np.ones(1)
