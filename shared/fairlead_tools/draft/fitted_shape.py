"""Capsules, the pairs to keep apart, and a pose to rest in where none of these is too near."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import Capsule
from fairlead.robot.link_poses import link_poses, random_positions
from fairlead_tools.draft.robot_document import DraftRobot
from fairlead_tools.draft.source_model import WHO
from fairlead_tools.shape import SAMPLES
from fairlead_tools.shape.capsule_pairs import CROWDED, CapsulePair, PairRule
from fairlead_tools.shape.file_text import file_text
from fairlead_tools.shape.robot_shape import RobotShape

_PER_LINK = (3, 2, 1, 6)  # what the gate has no room for is left out
_HOMES = 2_000
_ROOM = 1.5  # of the clearance, at home


@dataclass(frozen=True)
class FittedShape:
    """A robot's shape, and where it may rest.

    per_link: most capsules for a link. home: joint positions [rad or m]. home_source: where that
    pose is from, if it is not the draft's own.
    open: keys of robot.yaml that a person has to look at, and why.
    """

    per_link: int
    capsules: Sequence[Capsule]
    pairs: Sequence[CapsulePair]
    home: Mapping[str, float]
    home_source: str
    open: Mapping[str, str]

    def text(self, robot: str) -> str:
        """capsules.yaml."""
        command = f"fairlead robot capsules {robot} --max-per-link {self.per_link}"
        return file_text(robot, f"{command} --samples {SAMPLES}", self.capsules, self.pairs)


def fitted_shape(draft: DraftRobot, shape: RobotShape) -> FittedShape:
    """As few capsules as leave a pose to rest in.

    Where none do, pairs that are near in most poses are no longer checked: a person has to see.

    Raises:
        ConfigError: the gate has no room for the robot's links, or there is no such pose.
    """
    tried = []
    for per_link, capsules, pairs in _fits(draft, shape):
        home = _clear_home(draft, shape, capsules, pairs)
        if home is not None:
            return FittedShape(per_link, capsules, pairs, home, _source(draft, home), {})
        tried.append((per_link, capsules, pairs))
    per_link, capsules, pairs = tried[-1]
    crowded = [one for one in pairs if not one.why_not and one.near_share >= CROWDED]
    why = "capsules near in {:.0%} of all poses: to be confirmed"
    left = [
        replace(one, why_not=why.format(one.near_share)) if one in crowded else one for one in pairs
    ]
    home = _clear_home(draft, shape, capsules, left)
    if home is None:
        worst = max((one for one in left if not one.why_not), key=lambda one: one.near_share)
        raise ConfigError(
            f"{WHO}: {_HOMES} poses were tried, in each two links are too near, most often "
            f"{_links(capsules, worst)}: give them collision geometry that is less than their hulls"
        )
    links = {_links(capsules, one) for one in crowded}
    told = f"pairs near in most poses are not checked: {', '.join(sorted(links))}"
    return FittedShape(per_link, capsules, left, home, _source(draft, home), {"capsules": told})


def _source(draft: DraftRobot, home: Mapping[str, float]) -> str:
    """Of a pose that is not the draft's own."""
    return "" if home is draft.home else "a random pose, for in the model's own links are too near"


def _links(capsules: Sequence[Capsule], pair: CapsulePair) -> str:
    return f"{capsules[pair.first].link} and {capsules[pair.second].link}"


def _fits(
    draft: DraftRobot, shape: RobotShape
) -> Iterator[tuple[int, Sequence[Capsule], Sequence[CapsulePair]]]:
    """Capsules and pairs, more a link each time.

    Raises:
        ConfigError: there is no room even for one a link.
    """
    rule, found, refused = PairRule(draft.clearance_m, None, SAMPLES), 0, None
    for per_link in _PER_LINK:
        if found > per_link:
            continue
        try:
            capsules = shape.fitted(per_link)
            fit = per_link, capsules, shape.pairs(capsules, rule)
        except ConfigError as error:
            refused = error
            continue
        found = per_link
        yield fit
    if not found and refused is not None:
        raise refused


def _clear_home(
    draft: DraftRobot, shape: RobotShape, capsules: Sequence[Capsule], pairs: Sequence[CapsulePair]
) -> Mapping[str, float] | None:
    """The pose nearest to the model's in which no checked pair is too near; None: none is."""
    columns = random_positions(shape.robot, shape.tree, _HOMES)
    tried = {
        name: np.concatenate([[draft.home.get(name, 0.0)], values])
        for name, values in columns.items()
    }
    spans = capsule_spans(capsules, link_poses(shape.tree, tried))
    least: FloatArray = np.full(_HOMES + 1, np.inf)
    for one in pairs:
        if not one.why_not:
            least = np.minimum(least, pair_distances(capsules, spans, one.first, one.second))
    clear = np.flatnonzero(least >= _ROOM * draft.clearance_m)
    if not clear.size:
        return None
    away = np.sum([(values - values[0]) ** 2 for values in tried.values()], axis=0)
    best = int(clear[np.argmin(away[clear])])
    if not best:
        return draft.home
    ends = {one.name: (one.lower, one.upper) for one in draft.joints}
    return {
        name: inside(float(tried[name][best]), *ends[name]) if name in tried else position
        for name, position in draft.home.items()
    }


def inside(position: float, lower: float | None, upper: float | None) -> float:
    """A position to the micrometre, within its limits."""
    low, high = -np.inf if lower is None else lower, np.inf if upper is None else upper
    return float(min(max(round(position, 6), low), high))
