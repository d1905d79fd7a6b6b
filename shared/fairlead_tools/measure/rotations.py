"""Rotations as matrices ``[3, 3]``, quaternions xyzw and vectors [rad]."""

from __future__ import annotations

import math

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.link_poses import rotation_matrix

Pose = tuple[FloatArray, FloatArray]
"""Position [m] and rotation matrix of a frame in the root."""


def exponential(vector: FloatArray) -> FloatArray:
    """Rotation matrix of a rotation vector [rad]."""
    return rotation_of(_quaternion(vector))


def _quaternion(vector: FloatArray) -> FloatArray:
    angle = float(np.linalg.norm(vector))
    share = 0.5 * float(np.sinc(0.5 * angle / math.pi))  # sin(angle / 2) / angle
    return np.append(share * np.asarray(vector), math.cos(0.5 * angle))


def rotation_of(xyzw: FloatArray) -> FloatArray:
    """Rotation matrix of a quaternion, which need not have exactly unit norm."""
    return rotation_matrix(np.asarray(xyzw) / np.linalg.norm(xyzw))


def quaternion_of(rotation: FloatArray) -> FloatArray:
    """Unit quaternion xyzw of a rotation matrix: the eigenvector of its largest eigenvalue."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0.0, 0.0, 0.0],
            [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], 0.0, 0.0],
            [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], 0.0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    return np.asarray(np.linalg.eigh(k)[1][:, -1])


def angle_between(one: FloatArray, other: FloatArray) -> float:
    """Angle of the rotation that leads from one rotation matrix to the other, 0 to pi [rad]."""
    turn = one.T @ other
    twice_sine = turn[[2, 0, 1], [1, 2, 0]] - turn[[1, 2, 0], [2, 0, 1]]
    return math.atan2(float(np.linalg.norm(twice_sine)), float(np.trace(turn)) - 1.0)
