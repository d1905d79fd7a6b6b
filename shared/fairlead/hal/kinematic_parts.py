"""What the kinematic backend says of its parts, taken from the robot's manifest."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray, HalPart, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot import RobotManifest
from fairlead.robot_part import Part
from fairlead.robot_mode_limits import ModeLimits


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
    """SI range per controlled value; norms are spread evenly over three axes."""
    joints = [robot.joint(name) for name in part.joints]
    if mode is ControlMode.JOINT_POSITION:
        return (
            np.array([joint.lower for joint in joints]),
            np.array([joint.upper for joint in joints]),
        )
    if mode is ControlMode.GRIPPER_POSITION and limits.gripper_position is not None:
        grip = limits.gripper_position
        return np.array([grip.lower_m]), np.array([grip.upper_m])
    if mode is ControlMode.CARTESIAN_DELTA and limits.cartesian_delta is not None:
        delta = limits.cartesian_delta
        upper = np.repeat([delta.linear_limit_m, delta.angular_limit_rad], 3) / np.sqrt(3.0)
    elif mode is ControlMode.BODY_TWIST and limits.body_twist is not None:
        twist = limits.body_twist
        each = np.repeat([twist.linear_limit_m_s, twist.angular_limit_rad_s], 3)
        upper = np.where(np.isin(np.arange(6), twist.free_axes), each, 0.0)
    elif mode is ControlMode.JOINT_VELOCITY:
        upper = np.array([joint.velocity_limit for joint in joints])
    else:
        upper = np.ones(1)
    return -upper, upper
