"""Link poses from joint positions: pinocchio on the robot's own description."""

from __future__ import annotations

from collections.abc import Sequence

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
        frames: every other link of the description, and its place in what `poses` returns.

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
        self._computed = self._data.oMf
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
        self.frames = {name: index for index, name in bodies[1:]}

    def poses(self, positions: FloatArray) -> Sequence[SE3]:
        """T_base_frame [m] of each of `frames`, at its place, and of others.

        Args:
            positions: shape ``[n]``, every measured joint in wire order [rad or m].
        """
        q = positions[self._sources]
        if len(self._turning):
            angles = positions[self._turning_sources]
            q[self._turning] = np.cos(angles)
            q[self._turning + 1] = np.sin(angles)
        for column, source, multiplier, offset in self._mimics:
            q[column] = multiplier * positions[source] + offset
        pin.framesForwardKinematics(self._model, self._data, q)
        poses: Sequence[SE3] = self._computed.copy()  # the next call overwrites them
        return poses

    def _find_joints(self, robot: RobotManifest) -> None:
        """For each joint of the description: its column in q, its place on the wire.

        A joint without end stops (``continuous``) has two columns: the angle's cosine and sine.
        """
        measured = robot.measured_joint_names
        turning = list[tuple[int, int]]()
        self._sources = np.zeros(self._model.nq, dtype=np.intp)  # of other columns: any
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
            if joint.nq == 2:
                turning.append((joint.idx_q, measured.index(name)))
            else:
                self._sources[joint.idx_q] = measured.index(name)
        self._turning, self._turning_sources = np.array(turning, dtype=np.intp).reshape(-1, 2).T
