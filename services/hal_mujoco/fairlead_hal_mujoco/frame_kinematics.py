"""Poses and Jacobians of the model's frames at positions nobody has moved to yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.hal.mujoco_frames import Frame, find_frame
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.servos import Source


@dataclass(frozen=True)
class Pose:
    """T_world_frame: position [m], rotation as a quaternion wxyz, the simulator's order."""

    position: FloatArray
    quaternion_wxyz: FloatArray


class FrameKinematics:
    """The model's geometry on a copy of its state: nothing here moves the simulation.

    Frames go by the names of ``simulator.frames`` in robot.yaml.

    Args:
        data: the simulation, for the coordinates that no joint of the robot commands.
        sources: of the commanded joints, in wire order.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: RobotManifest,
        sources: Sequence[Source],
    ) -> None:
        self._model, self._live, self._copy = model, data, mujoco.MjData(model)
        self._robot, self._sources = robot, tuple(sources)

    def find(self, name: str) -> Frame:
        """The frame of that name.

        Raises:
            ConfigError: if robot.yaml does not say where it is, or the model has no such thing.
        """
        return find_frame(self._model, self._robot, name, "hal_mujoco")

    def place(self, positions: FloatArray) -> None:
        """Put the copy where the commanded joints are at ``positions``, shape ``[n_dof]``."""
        self._copy.qpos[:] = self._live.qpos
        for source, position in zip(self._sources, positions, strict=True):
            self._copy.qpos[list(source.qpos)] = source.shares(float(position))
        mujoco.mj_kinematics(self._model, self._copy)
        mujoco.mj_comPos(self._model, self._copy)

    def pose(self, frame: Frame) -> Pose:
        """T_world_frame at the last `place`."""
        data, quaternion_wxyz = self._copy, np.zeros(4)
        if frame.is_site:
            mujoco.mju_mat2Quat(quaternion_wxyz, data.site_xmat[frame.index])
            return Pose(data.site_xpos[frame.index].copy(), quaternion_wxyz)
        return Pose(data.xpos[frame.index].copy(), data.xquat[frame.index].copy())

    def jacobian(self, frame: Frame, joints: Sequence[int]) -> FloatArray:
        """Twist of the frame's origin per joint speed at the last `place`.

        Args:
            joints: indices into the commanded joints.

        Returns:
            Shape ``[6, len(joints)]``: linear, then angular, along the world's axes.
        """
        whole = np.zeros((6, self._model.nv))
        find = mujoco.mj_jacSite if frame.is_site else mujoco.mj_jacBody
        find(self._model, self._copy, whole[:3], whole[3:], frame.index)
        columns = [
            whole[:, list(source.dofs)] @ source.shares(1.0)
            for source in (self._sources[joint] for joint in joints)
        ]
        return np.stack(columns, axis=1)
