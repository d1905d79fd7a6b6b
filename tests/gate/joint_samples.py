"""Random states of a robot's joints."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest


def samples(robot: RobotManifest, count: int) -> tuple[FloatArray, FloatArray]:
    """Positions over each joint's range and velocities up to its limit, every measured joint."""
    rng = np.random.default_rng(7)
    joints = (*robot.joints, *robot.passive_joints)
    ranges = [(j.lower, j.upper) if j.has_bounds else (-np.pi, np.pi) for j in joints]
    lower, upper = np.array(ranges).T
    speeds = np.array([joint.velocity_limit for joint in joints])
    positions = rng.uniform(lower, upper, (count, len(joints)))
    return positions, rng.uniform(-speeds, speeds, positions.shape)
