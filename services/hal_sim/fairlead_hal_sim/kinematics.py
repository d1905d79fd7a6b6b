"""Poses of simulator bodies at the newest joint positions.

The simulator's own ``body_xpos`` is one physics step (2 ms) older than its ``qpos``. A
scratch copy is brought up to date instead of the simulation's data, so that looking
never changes a bit of what comes next.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from fairlead.hal.backend import FramePose
from fairlead.messages import FloatArray


class BodyPoses:
    """Body poses in the simulator's world frame, recomputed by `update`."""

    def __init__(self, sim: Any) -> None:
        self._model = sim.model._model
        self._data = sim.data._data
        self._scratch = mujoco.MjData(self._model)

    def update(self) -> None:
        """Take over the simulation's positions and recompute every body's pose."""
        self._scratch.qpos[:] = self._data.qpos
        self._scratch.mocap_pos[:] = self._data.mocap_pos
        self._scratch.mocap_quat[:] = self._data.mocap_quat
        mujoco.mj_kinematics(self._model, self._scratch)

    def body_id(self, name: str) -> int:
        """Number of a body by its name."""
        return int(mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, name))

    def parent(self, body: int) -> int:
        """Number of a body's parent body; the world is 0."""
        return int(self._model.body_parentid[body])

    def relative(self, parent: int, child: int) -> tuple[FloatArray, FloatArray]:
        """T_parent_child: translation [m] and rotation as a quaternion xyzw."""
        parent_quat = self._scratch.xquat[parent]
        inverse, rotation, offset = np.zeros(4), np.zeros(4), np.zeros(3)
        mujoco.mju_negQuat(inverse, parent_quat)
        mujoco.mju_mulQuat(rotation, inverse, self._scratch.xquat[child])
        step = self._scratch.xpos[child] - self._scratch.xpos[parent]
        mujoco.mju_rotVecQuat(offset, step, inverse)
        return offset, rotation[[1, 2, 3, 0]]

    def frame(self, parent: tuple[str, int], child: tuple[str, int]) -> FramePose:
        """The pose of one named body frame in another; each given as (name, body)."""
        translation, rotation = self.relative(parent[1], child[1])
        return FramePose(parent[0], child[0], translation, rotation)
