"""Poses and Jacobians of the model's frames at positions nobody has moved to yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError
from fairlead.hal.model_joints import Source, find_sources
from fairlead.hal.mujoco_frames import Frame, MujocoFrames, find_frame
from fairlead.messages import FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest


@dataclass(frozen=True)
class Pose:
    """T_world_frame: position [m], rotation as a quaternion wxyz, the simulator's order."""

    position: FloatArray
    quaternion_wxyz: FloatArray


class FrameKinematics:
    """The model's geometry on a copy of its state: nothing here moves a simulation.

    Frames go by the names of ``simulator.frames`` in robot.yaml.

    Args:
        data: the simulation, for the coordinates that no joint of the robot commands.
        sources: of the commanded joints, in wire order.
        who: the HAL, as errors call it.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: RobotManifest,
        sources: Sequence[Source],
        who: str,
    ) -> None:
        self._model, self._live, self._copy = model, data, mujoco.MjData(model)
        self._robot, self._sources, self.who = robot, tuple(sources), who

    def find(self, name: str) -> Frame:
        """The frame of that name.

        Raises:
            ConfigError: if robot.yaml does not say where it is, or the model has no such thing.
        """
        return find_frame(self._model, self._robot, name, self.who)

    def place(self, positions: FloatArray) -> None:
        """Put the copy where the commanded joints are at ``positions``, shape ``[n_dof]``."""
        self._copy.qpos[:] = self._live.qpos
        for source, position in zip(self._sources, positions, strict=True):
            self._copy.qpos[list(source.qpos)] = source.shares(float(position))
        mujoco.mj_kinematics(self._model, self._copy)
        mujoco.mj_comPos(self._model, self._copy)

    def frames(self) -> MujocoFrames:
        """All frames of the robot, for positions that it is told."""
        return MujocoFrames(self._model, self._live, self._robot, self.who)

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


def robot_kinematics(robot: RobotManifest, who: str) -> FrameKinematics:
    """By the robot's own model, ``robots/<id>/<id>.xml``, for a HAL without a simulation.

    Raises:
        ConfigError: there is none, or it does not fit the manifest.
    """
    path = robot_dir(robot.id) / f"{robot.id}.xml"
    if not path.is_file():
        raise ConfigError(f"{who}: expected an MJCF file for cartesian modes, got none at {path}")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"{who}: {path}: {' '.join(str(error).split())}") from None
    sources = find_sources(model, robot, who)[: robot.n_dof]
    return FrameKinematics(model, mujoco.MjData(model), robot, sources, who)
