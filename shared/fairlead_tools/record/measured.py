"""What a robot's joints and tools did within each tick, from its measured states."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fairlead.messages import FloatArray, JointState, floats
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import SafetyProfile

Curve = dict[int, float]
"""Value by tick."""


class Measured:
    """Curves by tick; what a row of tick n leads to is the state at the start of tick n + 1."""

    def __init__(
        self, states: Sequence[JointState], robot: RobotManifest, safety: SafetyProfile
    ) -> None:
        self._robot = robot
        self._safety = safety
        self._turns_about = safety.base.yaw_axis_m if safety.base is not None else (0.0, 0.0)
        self.ticks = np.array([state.tick for state in states], dtype=np.int64)
        width = len(robot.measured_joint_names)
        self._positions = _rows([state.positions for state in states], width)
        self._velocities = _rows([state.velocities for state in states], width)
        tree = description_tree(robot)
        names = robot.measured_joint_names
        self._poses = link_poses(
            tree, {name: self._positions[:, index] for index, name in enumerate(names)}
        )
        self._joined = np.array(  # pairs of states of which one is the next tick of the other
            [
                later.tick == one.tick + 1 and later.episode_tick == one.episode_tick
                for one, later in pairwise(states)
            ],
            dtype=bool,
        )

    @property
    def frames(self) -> frozenset[str]:
        """Those that a pose or a motion may be given in."""
        return frozenset(self._poses)

    def position(self, name: str) -> Curve:
        """Of one joint [rad or m]."""
        return self._after(self._positions[:, self._index(name)])

    def velocity(self, name: str) -> Curve:
        """Of one joint [rad/s or m/s]."""
        return self._after(self._velocities[:, self._index(name)])

    def yaw(self) -> Curve:
        """Of the base, at the start of each tick [rad]."""
        values = self._positions[:, self._index(self._robot.base_joints[2])]
        return dict(zip(self.ticks.tolist(), values.tolist(), strict=True))

    def tool_motion(self, tool: str, frame: str) -> list[Curve]:
        """Steps along x, y, z [m] and turns about them [rad] of a frame, along ``frame``'s axes."""
        rotation, translation = self._seen_from(tool, frame)
        moved = np.diff(translation, axis=0)
        turned = _rotation_vectors(rotation[1:] @ rotation[:-1].transpose(0, 2, 1))
        ticks = self.ticks[:-1][self._joined].tolist()
        values = np.hstack([moved, turned])[self._joined]
        return [dict(zip(ticks, values[:, axis].tolist(), strict=True)) for axis in range(6)]

    def tool_pose(self, tool: str, frame: str, since: FloatArray) -> list[Curve]:
        """x, y, z [m] of a frame in ``frame``, and its turn [rad] from the rotation ``since``."""
        rotation, translation = self._seen_from(tool, frame)
        values = np.hstack([translation, _rotation_vectors(rotation @ since.T)])
        return [self._after(values[:, axis]) for axis in range(6)]

    def base_twist(self) -> list[Curve]:
        """Of the base's frame along its own axes: x, y, z [m/s] and about them [rad/s]."""
        x, y, yaw = (self._index(name) for name in self._robot.base_joints)
        cosine, sine = np.cos(self._positions[:, yaw]), np.sin(self._positions[:, yaw])
        along, across, spin = (self._velocities[:, joint] for joint in (x, y, yaw))
        axis = self._turns_about
        still = np.zeros_like(spin)
        values = (
            cosine * along + sine * across + spin * axis[1],
            cosine * across - sine * along - spin * axis[0],
            still, still, still, spin,
        )  # fmt: skip
        return [self._after(value) for value in values]

    def base_moves(self) -> frozenset[int]:
        """Ticks at whose start or end a joint of the base was not at standstill."""
        limits = self._safety.measured
        moving = {
            int(self.ticks[state])
            for name in self._robot.base_joints
            for state in np.flatnonzero(
                np.abs(self._velocities[:, self._index(name)]) >= limits[name].standstill_per_s
            )
        }
        return frozenset(moving | {tick - 1 for tick in moving})

    def _index(self, name: str) -> int:
        return self._robot.measured_joint_names.index(name)

    def _after(self, values: FloatArray) -> Curve:
        return dict(zip((self.ticks - 1).tolist(), values.tolist(), strict=True))

    def _seen_from(self, tool: str, frame: str) -> tuple[FloatArray, FloatArray]:
        """Rotation ``[n, 3, 3]`` and translation ``[n, 3]`` [m] of ``tool`` in ``frame``."""
        seen, origin = self._poses[tool], self._poses[frame]
        back = np.asarray(origin.rotation).transpose(0, 2, 1)
        away = seen.translation - origin.translation
        return back @ seen.rotation, (back @ away[..., None])[..., 0]


def rotation_vector(matrix: FloatArray) -> FloatArray:
    """Axis times angle [rad] of one rotation, ``[3]``."""
    vector: FloatArray = _rotation_vectors(matrix[None])[0]
    return vector


def _rotation_vectors(matrices: FloatArray) -> FloatArray:
    """``[n, 3, 3]`` to ``[n, 3]``; a half turn has no direction of its own and reads as 0."""
    skew = matrices - matrices.transpose(0, 2, 1)
    across = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    length = np.linalg.norm(across, axis=1)
    trace = np.trace(matrices, axis1=1, axis2=2)
    angle = np.arctan2(length, trace - 1.0)
    scale = np.divide(angle, length, out=np.full_like(angle, 0.5), where=length > 1e-12)
    return np.asarray(across * scale[:, None])


def _rows(blocks: Sequence[bytes], width: int) -> FloatArray:
    return np.array([floats(block) for block in blocks]).reshape(-1, width)
