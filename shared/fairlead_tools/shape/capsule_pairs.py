"""Which capsules of a robot are kept apart, and why not the others: seen over random poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import mujoco
import numpy as np
import numpy.typing as npt

from fairlead.messages import FloatArray
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import Capsule
from fairlead.robot.description import DescriptionTree
from fairlead.robot.gate_geometry import is_swept
from fairlead.robot.link_poses import Poses, link_poses, random_positions
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.shape.geometry import GeometrySource

_FAR_M = 1.0  # farther apart is told as this
_NUDGE_M, _TRIES = 1e-6, 5


def links_apart(
    source: GeometrySource,
    poses: Mapping[str, Poses],
    first: Sequence[str],
    second: Sequence[str],
) -> FloatArray:
    """Smallest distance between two groups of links in each pose, shape ``[n]`` [m].

    Negative where they overlap.
    """
    data = mujoco.MjData(source.model)
    geoms = [[one for link in group for one in source.geoms(link)] for group in (first, second)]
    count = len(next(iter(poses.values())).translation)
    far = np.full(count, _FAR_M)
    for pose in range(count):
        for link, geom, rotation, translation in geoms[0] + geoms[1]:
            placed = poses[link].rotation[pose]
            data.geom_xpos[geom] = placed @ translation + poses[link].translation[pose]
            data.geom_xmat[geom] = (placed @ rotation).ravel()
        far[pose] = min(
            (
                _apart(source.model, data, one[1], other[1])
                for one in geoms[0]
                for other in geoms[1]
            ),
            default=_FAR_M,
        )
    return far


def _apart(model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> float:
    """MuJoCo now and then answers 0 for geoms that are apart; moved by a hair it does not."""
    for _ in range(_TRIES):
        distance = float(mujoco.mj_geomDistance(model, data, first, second, _FAR_M, None))
        if distance != 0.0:
            return distance
        data.geom_xpos[first] += _NUDGE_M
    return 0.0


BoolArray = npt.NDArray[np.bool_]

CROWDED = 0.25  # of all poses: nobody wants a pair that refuses so much


@dataclass(frozen=True)
class CapsulePair:
    """Two capsules, by index.

    why_not: why they are not checked, "" where they are.
    least_m: the smallest distance seen, negative where they overlap.
    near_share: of the poses seen, the share in which they were nearer than the clearance.
    """

    first: int
    second: int
    why_not: str
    least_m: float
    near_share: float


@dataclass(frozen=True)
class PairRule:
    """When a pair is left out.

    clearance_m: distance that has to remain.
    drop_margin_m: leave out what never came nearer than the clearance and this; None keeps it.
    samples: random poses within the joints' limits.
    """

    clearance_m: float
    drop_margin_m: float | None
    samples: int


LinksApart = Callable[[Mapping[str, Poses], str, str], FloatArray]
"""Distance of two links themselves, not of their capsules, in each pose ``[n]`` [m]."""


def find_pairs(
    robot: RobotManifest,
    tree: DescriptionTree,
    capsules: Sequence[Capsule],
    rule: PairRule,
    links_apart: LinksApart,
    say: Callable[[str], None],
) -> list[CapsulePair]:
    """Every pair of capsules on different links; ``say`` gets a line of progress for each."""
    poses = link_poses(tree, random_positions(robot, tree, rule.samples))
    spans = capsule_spans(capsules, poses)
    body, joined = _bodies(robot, tree)
    found, near = [], {}
    every = [
        (i, j)
        for i, j in combinations(range(len(capsules)), 2)
        if capsules[i].link != capsules[j].link
    ]
    for number, (i, j) in enumerate(every, start=1):
        one, other = capsules[i].link, capsules[j].link
        say(f"pair {number} of {len(every)} in {rule.samples} poses: {one}, {other}")
        far = pair_distances(capsules, spans, i, j)
        near[i, j] = far < rule.clearance_m
        why_not = _by_joints(body[one], body[other], joined) or _by_poses(far, rule)
        found.append(CapsulePair(i, j, why_not, float(far.min()), float(near[i, j].mean())))

    def apart(one: str, other: str) -> FloatArray:
        say(f"distances of links that are near in many poses: {one}, {other}")
        return links_apart(poses, one, other)

    return _without_crowded(found, near, capsules, apart, rule)


def _by_joints(one: str, other: str, joined: Mapping[frozenset[str], str]) -> str:
    """Why two rigid bodies cannot be kept apart, "" if they can."""
    return "fixed to each other" if one == other else joined.get(frozenset((one, other)), "")


def _by_poses(far: FloatArray, rule: PairRule) -> str:
    """Why a pair at these distances is left out, "" if it is not."""
    if bool(np.all(far < rule.clearance_m)):
        return f"always nearer than {rule.clearance_m:g} m ({rule.samples} poses)"
    if rule.drop_margin_m is not None:
        enough_m = rule.clearance_m + rule.drop_margin_m
        if bool(np.all(far > enough_m)):
            return f"never nearer than {enough_m:g} m ({rule.samples} poses)"
    return ""


def _without_crowded(
    pairs: list[CapsulePair],
    near: Mapping[tuple[int, int], BoolArray],
    capsules: Sequence[Capsule],
    links_apart: Callable[[str, str], FloatArray],
    rule: PairRule,
) -> list[CapsulePair]:
    """Leave out capsules that are near in many poses only because they are wider than their links.

    Such a pair would forbid what the robot does all day. It is no loss where, in every pose in
    which the links themselves touch, a pair that stays is nearer than the clearance.
    """
    crowded = [one for one in pairs if not one.why_not and one.near_share >= CROWDED]
    staying = [
        near[one.first, one.second] for one in pairs if not one.why_not and one not in crowded
    ]
    noticed = np.any(staying, axis=0) if staying else np.zeros(rule.samples, dtype=bool)
    excused = {}
    for one in crowded:
        touch = links_apart(capsules[one.first].link, capsules[one.second].link) < 0.0
        if not np.any(touch & ~noticed):
            excused[one] = (
                f"capsules near in {one.near_share:.0%} of {rule.samples} poses, the links touch "
                f"in {touch.mean():.0%}; in each of those another checked pair is near"
            )
    return [replace(one, why_not=excused.get(one, one.why_not)) for one in pairs]


def _bodies(
    robot: RobotManifest, tree: DescriptionTree
) -> tuple[dict[str, str], dict[frozenset[str], str]]:
    """The rigid body of each link, by its first link, and which joint joins two of them."""
    body, joined = {tree.root: tree.root}, {}
    for link in tree.links:
        moves = link.joint is not None and not is_swept(robot, tree, link)
        body[link.name] = link.name if moves else body[link.parent]
        if moves:
            joined[frozenset((link.name, body[link.parent]))] = f"joined by {link.joint}"
    return body, joined
