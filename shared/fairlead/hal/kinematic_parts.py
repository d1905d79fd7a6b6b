"""What the kinematic backend says of its parts, taken from the robot's manifest."""

from __future__ import annotations

import math

import numpy as np

from fairlead.messages import FloatArray, HalPart, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import ModeLimits
from fairlead.robot.part import Part


def describe_part(robot: RobotManifest, part: Part, profile: str) -> HalPart:
    """The part with the limits of a safety profile as its command ranges."""
    limits = robot.profile(profile).parts[part.name]
    ranges = []
    for mode in part.control_modes:
        lower, upper = _range(robot, part, mode, limits)
        ranges.append(ModeRange(mode=mode, lower=pack_floats(lower), upper=pack_floats(upper)))
    return HalPart(
        name=part.name,
        simulator_part=part.simulator_part,
        joints=part.joints,
        ranges=tuple(ranges),
    )


def finger_shares(robot: RobotManifest) -> FloatArray:
    """How passive joints follow commanded ones: ``passive = shares @ commanded``.

    A gripper that is the difference of two fingers opens each by half; others stand at 0.
    """
    shares = np.zeros((len(robot.passive_joints), robot.n_dof))
    if robot.simulator is None:
        return shares
    names = robot.simulator.joints
    for column, joint in enumerate(robot.joint_names):
        fingers = names.get(joint, ())
        if len(fingers) != 2:
            continue
        for row, passive in enumerate(robot.passive_joint_names):
            if names.get(passive) == (fingers[0],):
                shares[row, column] = 0.5
            elif names.get(passive) == (fingers[1],):
                shares[row, column] = -0.5
    return shares


def _range(
    robot: RobotManifest, part: Part, mode: ControlMode, limits: ModeLimits
) -> tuple[FloatArray, FloatArray]:
    """SI range per controlled value."""
    joints = [robot.joint(name) for name in part.joints]
    if mode in (ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT):
        return (
            np.array([joint.lower for joint in joints]),
            np.array([joint.upper for joint in joints]),
        )
    if mode is ControlMode.CARTESIAN_POSE and limits.cartesian_pose is not None:
        box = limits.cartesian_pose
        return np.array([*box.lower_m, *[-1.0] * 4]), np.array([*box.upper_m, *[1.0] * 4])
    if mode is ControlMode.GRIPPER_POSITION and limits.gripper_position is not None:
        grip = limits.gripper_position
        return np.array([grip.lower_m]), np.array([grip.upper_m])
    if mode is ControlMode.GRIPPER_BINARY:
        return np.zeros(1), np.ones(1)
    upper = _largest(joints, mode, limits)
    return -upper, upper


def _largest(joints: list[Joint], mode: ControlMode, limits: ModeLimits) -> FloatArray:
    """The largest size of each value of a mode that means the same both ways."""
    if mode is ControlMode.JOINT_VELOCITY:
        return np.array([joint.velocity_limit for joint in joints])
    if mode is ControlMode.JOINT_TORQUE:
        return np.array([joint.effort_limit for joint in joints])
    if mode is ControlMode.CARTESIAN_DELTA and limits.cartesian_delta is not None:
        delta = limits.cartesian_delta
        return _axes(delta.linear_limit_m, delta.angular_limit_rad)
    if mode is ControlMode.CARTESIAN_TWIST and limits.cartesian_twist is not None:
        twist = limits.cartesian_twist
        return _axes(twist.linear_limit_m_s, twist.angular_limit_rad_s)
    if mode is ControlMode.BODY_TWIST and limits.body_twist is not None:
        body = limits.body_twist
        each = np.repeat([body.linear_limit_m_s, body.angular_limit_rad_s], 3)
        return np.where(np.isin(np.arange(6), body.free_axes), each, 0.0)
    return np.ones(1)


def _axes(linear: float, angular: float) -> FloatArray:
    """Norms, spread evenly over three axes each."""
    return np.array([linear] * 3 + [angular] * 3) / math.sqrt(3.0)
