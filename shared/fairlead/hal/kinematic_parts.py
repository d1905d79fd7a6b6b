"""What the kinematic backend says of its parts, taken from the robot's manifest."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray, HalPart, ModeRange, pack_floats
from fairlead.robot.command_ranges import command_range
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part


def describe_part(robot: RobotManifest, part: Part, profile: str) -> HalPart:
    """The part with the limits of a safety profile as its command ranges."""
    limits = robot.profile(profile).parts[part.name]
    ranges = []
    for mode in part.control_modes:
        lower, upper = command_range(robot, part, mode, limits)
        ranges.append(ModeRange(mode=mode, lower=pack_floats(lower), upper=pack_floats(upper)))
    return HalPart(
        name=part.name,
        simulator_part=part.simulator_part,
        joints=part.joints,
        ranges=tuple(ranges),
    )


def finger_shares(robot: RobotManifest) -> FloatArray:
    """How passive joints follow commanded ones: ``passive = shares @ commanded``.

    A gripper that is the difference of two fingers opens each by half; others stand still.
    """
    shares = np.zeros((len(robot.passive_joints), robot.n_dof))
    for column, joint in enumerate(robot.joint_names):
        fingers = robot.simulator_joints(joint)
        if len(fingers) != 2:
            continue
        for row, passive in enumerate(robot.passive_joint_names):
            if robot.simulator_joints(passive) == (fingers[0],):
                shares[row, column] = 0.5
            elif robot.simulator_joints(passive) == (fingers[1],):
                shares[row, column] = -0.5
    return shares
