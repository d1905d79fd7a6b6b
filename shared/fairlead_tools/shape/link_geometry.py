"""The geometry of a robot's links: what each of them carries, fingers over their whole range."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.bare_links import is_swept
from fairlead.robot.description_tree import DescriptionTree, Link
from fairlead.robot.link_poses import Poses, motion, placement
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.shape.convex_part import ConvexPart

Geometry = dict[str, list[ConvexPart]]

_TURN_STEP_RAD = 0.1  # of a finger that turns


def with_swept_fingers(
    robot: RobotManifest, tree: DescriptionTree, own: Mapping[str, Iterable[ConvexPart]]
) -> Geometry:
    """Pieces of each link that has any, those of fingers given to what carries them.

    No command says where a finger is that is measured and not commanded (a gripper's), so it
    counts as being everywhere it can be.
    """
    geometry = {name: list(own.get(name, ())) for name in tree.frames}
    for link in reversed(tree.links):
        if is_swept(robot, link):
            carried = geometry.pop(link.name)
            geometry[link.parent] += [part for one in carried for part in _swept(robot, link, one)]
    return {name: pieces for name, pieces in geometry.items() if pieces}


def _swept(robot: RobotManifest, link: Link, piece: ConvexPart) -> list[ConvexPart]:
    """What covers a piece at every position of its joint, in the parent's frame."""
    joint = robot.joint(link.joint or "")
    if joint.type == "prismatic":
        ends = _at(link, np.array([joint.lower, joint.upper]), piece.points)
        return [ConvexPart(np.concatenate(list(ends)), piece.radius)]
    steps = max(2, int(np.ceil((joint.upper - joint.lower) / _TURN_STEP_RAD)) + 1)
    turns = np.linspace(joint.lower, joint.upper, steps)
    # Between two positions a point bulges out of the chord by less than its sagitta.
    bulge = float(np.linalg.norm(piece.points, axis=1).max()) * (
        1 - np.cos((turns[1] - turns[0]) / 2)
    )
    placed = _at(link, turns, piece.points)
    return [ConvexPart(np.concatenate(pair), piece.radius + bulge) for pair in pairwise(placed)]


def _at(link: Link, positions: FloatArray, points: FloatArray) -> list[FloatArray]:
    rotation, translation = placement(link)
    count = len(positions)
    still = Poses(
        np.broadcast_to(rotation, (count, 3, 3)), np.broadcast_to(translation, (count, 3))
    )
    poses = still.then(*motion(link, positions))
    return [
        points @ turn.T + shift
        for turn, shift in zip(poses.rotation, poses.translation, strict=True)
    ]
