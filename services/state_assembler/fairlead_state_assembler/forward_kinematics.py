"""Link poses from joint positions: pinocchio on the robot's own description."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.description import description_tree
from fairlead.robot.manifest import RobotManifest
from fairlead_state_assembler.pose_decoding import SE3


class ForwardKinematics:
    """Forward kinematics of one robot, prepared once.

    Attributes:
        base_frame: the description's root; every pose is given in it.
        frames: every other link of the description.

    Raises:
        ConfigError: if the description needs a joint the robot does not measure, or its
            root is not the manifest's base frame; if pinocchio cannot read it.
    """

    def __init__(self, robot: RobotManifest) -> None:
        path = robot.description_path()
        try:
            self._model = pin.buildModelFromUrdf(str(path))
        except ValueError as error:
            raise ConfigError(f"{path}: {error}") from None
        self._data = self._model.createData()
        self._q = np.zeros(self._model.nq)
        self._find_joints(robot)
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
        if self._turning:
            angles = positions[self._turning_sources]
            self._q[self._turning] = np.cos(angles)
            self._q[[column + 1 for column in self._turning]] = np.sin(angles)
        for column, source, multiplier, offset in self._mimics:
            self._q[column] = multiplier * positions[source] + offset
        pin.framesForwardKinematics(self._model, self._data, self._q)
        placements = self._data.oMf
        return [placements[index] for index in self._ids]

    def _find_joints(self, robot: RobotManifest) -> None:
        """For each joint of the description: its column in q, its place on the wire.

        A joint without end stops (``continuous``) has two columns: the angle's cosine and sine.
        """
        measured = robot.measured_joint_names
        self._columns: list[int] = []
        self._sources: list[int] = []
        self._turning: list[int] = []
        self._turning_sources: list[int] = []
        self._mimics: list[tuple[int, int, float, float]] = []
        told = (link.mimic for link in description_tree(robot).links if link.mimic)
        mimics = {mimic.name: mimic for mimic in told}
        for name in list(self._model.names)[1:]:
            mimic = mimics.get(name)
            if mimic is not None:
                column = self._model.joints[self._model.getJointId(name)].idx_q
                source = measured.index(mimic.joint)
                self._mimics.append((column, source, mimic.multiplier, mimic.offset))
                continue
            if name not in measured:
                raise ConfigError(
                    expected(
                        str(robot.description_path()), "joints the robot measures", name, measured
                    )
                )
            joint = self._model.joints[self._model.getJointId(name)]
            is_continuous = joint.nq == 2
            (self._turning if is_continuous else self._columns).append(joint.idx_q)
            sources = self._turning_sources if is_continuous else self._sources
            sources.append(measured.index(name))
