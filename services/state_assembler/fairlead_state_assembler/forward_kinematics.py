"""Link poses from joint positions: pinocchio on the robot's own description."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead_state_assembler.pose_decoding import SE3


class ForwardKinematics:
    """Forward kinematics of one robot, prepared once.

    Attributes:
        base_frame: the description's root; every pose is given in it.
        frames: every other link of the description.

    Raises:
        ConfigError: if the description needs a joint the robot does not measure, or its
            root is not the manifest's base frame.
    """

    def __init__(self, robot: RobotManifest) -> None:
        path = robot.description_path()
        self._model = pin.buildModelFromUrdf(str(path))
        self._data = self._model.createData()
        self._q = np.zeros(self._model.nq)
        self._columns, self._sources = self._joint_columns(robot)
        bodies = [
            (index, frame.name)
            for index, frame in enumerate(self._model.frames)
            if frame.type == pin.FrameType.BODY
        ]
        self.base_frame = bodies[0][1]
        if self.base_frame != robot.base_frame:
            raise ConfigError(
                expected(str(path), f"root link {robot.base_frame!r}", repr(self.base_frame))
            )
        self._ids = [index for index, _ in bodies[1:]]
        self.frames = tuple(name for _, name in bodies[1:])

    def poses(self, positions: FloatArray) -> list[SE3]:
        """T_base_frame of each of `frames` [m].

        The poses are views that the next call overwrites: copy what is to be kept.

        Args:
            positions: shape ``[n]``, every measured joint in wire order [rad or m].
        """
        self._q[self._columns] = positions[self._sources]
        pin.framesForwardKinematics(self._model, self._data, self._q)
        placements = self._data.oMf
        return [placements[index] for index in self._ids]

    def _joint_columns(self, robot: RobotManifest) -> tuple[list[int], list[int]]:
        """For each joint of the description: its column in q, its place on the wire."""
        measured = robot.measured_joint_names
        columns, sources = [], []
        for name in list(self._model.names)[1:]:
            if name not in measured:
                raise ConfigError(
                    expected(
                        str(robot.description_path()), "joints the robot measures", name, measured
                    )
                )
            columns.append(self._model.joints[self._model.getJointId(name)].idx_q)
            sources.append(measured.index(name))
        return columns, sources
