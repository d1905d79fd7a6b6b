"""Where a robot's links are, for many joint positions at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fairlead.robot.description import DescriptionTree, Link
from fairlead.robot.manifest import RobotManifest

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Poses:
    """Poses of one frame in the root link's: ``[n, 3, 3]`` and ``[n, 3]`` [m]."""

    rotation: FloatArray
    translation: FloatArray

    def then(self, rotation: FloatArray, translation: FloatArray) -> Poses:
        """Poses of a frame that this one carries, from its pose in this one."""
        return Poses(self.rotation @ rotation, self.apply(translation))

    def apply(self, point: FloatArray) -> FloatArray:
        """Points of this frame (``[3]`` or ``[n, 3]``) in the root's: ``[n, 3]``."""
        return np.asarray((self.rotation @ point[..., None])[..., 0] + self.translation)


def link_poses(tree: DescriptionTree, positions: Mapping[str, FloatArray]) -> dict[str, Poses]:
    """Poses of every link.

    Args:
        positions: of each joint of the description, shape ``[n]`` [rad or m].
    """
    count = max((len(values) for values in positions.values()), default=1)
    still = Poses(np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3)))
    poses = {tree.root: still}
    for link in tree.links:
        placed = poses[link.parent].then(*placement(link))
        if link.joint:
            placed = placed.then(*motion(link, positions[link.joint]))
        elif link.mimic is not None:
            told = link.mimic.multiplier * positions[link.mimic.joint] + link.mimic.offset
            placed = placed.then(*motion(link, told))
        poses[link.name] = placed
    return poses


def random_positions(
    robot: RobotManifest, tree: DescriptionTree, samples: int
) -> dict[str, FloatArray]:
    """Positions ``[samples]`` of each joint of the description, anywhere within its limits."""
    rng = np.random.default_rng(0)
    found = {}
    for link in tree.links:
        if link.joint is not None:
            joint = robot.joint(link.joint)
            low, high = (joint.lower, joint.upper) if joint.has_bounds else (-np.pi, np.pi)
            found[link.joint] = rng.uniform(low, high, samples)
    return found


def placement(link: Link) -> tuple[FloatArray, FloatArray]:
    """How a link hangs on its parent at joint position 0: ``[3, 3]`` and ``[3]``."""
    return rotation_matrix(np.array(link.rotation_xyzw)), np.array(link.translation)


def rotation_matrix(quaternion_xyzw: FloatArray) -> FloatArray:
    """The matrix of a unit quaternion: ``[3, 3]``."""
    vector, w = quaternion_xyzw[:3], quaternion_xyzw[3]
    return np.asarray(
        (w * w - vector @ vector) * np.eye(3)
        + 2 * np.outer(vector, vector)
        + 2 * w * _cross(vector)
    )


def motion(link: Link, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What a joint adds to its placement at positions ``[n]``: ``[n, 3, 3]`` and ``[n, 3]``."""
    axis = np.array(link.axis)
    kind = link.kind if link.mimic is None else link.mimic.kind
    if kind == "prismatic":
        still = np.broadcast_to(np.eye(3), (len(positions), 3, 3))
        return still, positions[:, None] * axis
    across = _cross(axis)
    sine, versine = np.sin(positions)[:, None, None], 1.0 - np.cos(positions)[:, None, None]
    return np.eye(3) + sine * across + versine * (across @ across), np.zeros((len(positions), 3))


def _cross(vector: FloatArray) -> FloatArray:
    """The matrix of ``vector x``."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
