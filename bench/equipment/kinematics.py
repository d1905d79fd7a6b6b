"""Where a tool is and how it moves, by pinocchio from the robot's description.

The gate computes the same from the tree in its own file, with its own code.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from fairlead.messages import FloatArray

Pose = tuple[FloatArray, FloatArray]
"""Position [m] and rotation matrix of a frame in another."""


class Kinematics:
    """One robot's description. Joints that are not in it move nothing."""

    def __init__(self, urdf: Path, joints: tuple[str, ...]) -> None:
        self._model: Any = pinocchio.buildModelFromUrdf(str(urdf))
        self._data: Any = self._model.createData()
        self._joints = [
            (index, self._model.joints[self._model.getJointId(name)])
            for index, name in enumerate(joints)
            if self._model.existJointName(name)
        ]

    def pose(self, positions: FloatArray, tool: str, frame: str) -> Pose:
        """The tool frame in ``frame``. positions: measured, commanded then passive."""
        pinocchio.framesForwardKinematics(self._model, self._data, self._q(positions))
        found = self._frame(frame).actInv(self._frame(tool))
        return np.array(found.translation), np.array(found.rotation)

    def twist(
        self, positions: FloatArray, velocities: FloatArray, tool: str, frame: str
    ) -> FloatArray:
        """The tool frame's velocity and angular velocity in ``frame``, ``[6]`` [m/s, rad/s]."""
        v = np.zeros(self._model.nv)
        for index, joint in self._joints:
            v[joint.idx_v] = velocities[index]
        pinocchio.forwardKinematics(self._model, self._data, self._q(positions), v)
        pinocchio.updateFramePlacements(self._model, self._data)
        moved = pinocchio.getFrameVelocity(
            self._model, self._data, self._id(tool), pinocchio.LOCAL_WORLD_ALIGNED
        )
        turn = self._frame(frame).rotation.T
        return np.concatenate([turn @ moved.linear, turn @ moved.angular])

    def _q(self, positions: FloatArray) -> FloatArray:
        q: FloatArray = np.asarray(pinocchio.neutral(self._model), dtype=np.float64)
        for index, joint in self._joints:
            angle = float(positions[index])
            is_unbounded = joint.nq == 2
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                (math.cos(angle), math.sin(angle)) if is_unbounded else angle
            )
        return q

    def _id(self, frame: str) -> int:
        return int(self._model.getFrameId(frame))

    def _frame(self, frame: str) -> Any:
        return self._data.oMf[self._id(frame)]


def rotation_of(xyzw: FloatArray) -> FloatArray:
    """Rotation matrix of a quaternion, which need not have exactly unit norm."""
    x, y, z, w = (np.asarray(xyzw) / np.linalg.norm(xyzw)).tolist()
    return np.asarray(pinocchio.Quaternion(w, x, y, z).toRotationMatrix(), dtype=np.float64)


def quaternion_of(rotation: FloatArray) -> FloatArray:
    """Unit quaternion xyzw of a rotation matrix."""
    return np.asarray(pinocchio.Quaternion(rotation).coeffs(), dtype=np.float64)


def angle_between(one: FloatArray, other: FloatArray) -> float:
    """Angle of the rotation that leads from one rotation matrix to the other, 0 to pi [rad]."""
    turn = one.T @ other
    twice_sine = turn[[2, 0, 1], [1, 2, 0]] - turn[[1, 2, 0], [2, 0, 1]]
    return math.atan2(float(np.linalg.norm(twice_sine)), float(np.trace(turn)) - 1.0)
