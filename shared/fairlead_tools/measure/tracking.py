"""The tracking model of each mode: gains, residuals and lags over many ticks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick
from fairlead_tools.measure.motion import answers, distances
from fairlead_tools.measure.rows import TARGETS

STEADY_TICKS = 8
"""Ticks of the same row after which the motion counts as steady."""
FULL_SHARE = 0.5
"""Of the largest row seen: below it a share says little, and is left out."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Sample:
    """One tick of one half or joint, in the row's own unit.

    came_from: two points that motion may still be at, of which the first is the row before (or
    zero) and the second what was measured when the row began, after a hold. same_for: ticks for
    which the row has been the same.
    """

    told: FloatArray
    moved: tuple[FloatArray, ...]
    before: FloatArray | None
    started_at: FloatArray
    same_for: int

    def corners(self, gain: Range) -> list[FloatArray]:
        """What the gain allows is all between the row before and its shares of this one."""
        now = [share * self.told for share in gain]
        if self.before is None:
            return [np.zeros_like(self.told), self.started_at, *now]
        return [*(share * self.before for share in gain), *now]


def hull_distances(points: FloatArray, corners: FloatArray) -> FloatArray:
    """From each point ``[n, d]`` to the nearest mixture of its corners ``[n, k, d]``: ``[n]``.

    The nearest mixture is inside the corners of some subset: of each, its nearest point counts if
    no corner's share is negative.
    """
    count, most, _ = corners.shape
    scale = max(float(np.abs(corners).max(initial=0.0)), float(np.abs(points).max(initial=0.0)))
    best = np.full(count, np.inf)
    for size in range(1, most + 1):
        for chosen in combinations(range(most), size):
            first, edges = corners[:, chosen[0]], corners[:, chosen[1:]] - corners[:, [chosen[0]]]
            away = points - first
            gram = edges @ edges.transpose(0, 2, 1) + 1e-12 * (scale or 1.0) ** 2 * np.eye(size - 1)
            shares = np.linalg.solve(gram, edges @ away[:, :, None])[:, :, 0]
            left = np.linalg.norm(away - (shares[:, None] @ edges)[:, 0], axis=1)
            inside = np.all(shares >= 0.0, axis=1) & (shares.sum(axis=1) <= 1.0)
            best = np.where(inside, np.minimum(best, left), best)
    return best


@dataclass
class Track:
    """What one half or joint of one part and mode did in one kind of drive."""

    samples: list[Sample] = field(default_factory=list)

    def shares(self, least_same: int = 0, most_same: int = 1 << 30) -> Range | None:
        """Smallest and largest share along the told direction, of rows near full scale."""
        sizes = [float(np.linalg.norm(sample.told)) for sample in self.samples]
        least = FULL_SHARE * max(sizes, default=0.0)
        found = [
            float(way @ sample.told) / size**2
            for sample, size in zip(self.samples, sizes, strict=True)
            if size > 0.0 and size >= least and least_same <= sample.same_for <= most_same
            for way in sample.moved
        ]
        return (min(found), max(found)) if found else None

    def residual(self, gain: Range) -> float:
        """Farthest from everything that the gain allows, in the row's unit."""
        if not self.samples:
            return 0.0
        pairs = [(way, one.corners(gain)) for one in self.samples for way in one.moved]
        points, corners = (np.array(column) for column in zip(*pairs, strict=True))
        return float(hull_distances(points, corners).max())


class TrackingModel:
    """Tracks by (part, mode, half or joint) and kind of drive; lags of targets likewise."""

    def __init__(self, driven: DrivenRobot) -> None:
        self._driven = driven
        self.tracks: dict[tuple[str, str, str], dict[str, Track]] = {}
        self.lags: dict[tuple[str, str, str], dict[str, float]] = {}

    def take(self, ticks: Iterable[Tick]) -> None:
        """Ticks of one drive, but for those in contact."""
        last: Tick | None = None
        same: dict[str, int] = {}
        for tick in ticks:
            follows = last is not None and last.after is tick.before
            past = last.commands if last is not None and follows else {}
            for part in tick.commands:
                same[part] = same.get(part, 0) + 1 if _is_same(part, past, tick.commands) else 0
                if tick.is_free:
                    self._take(part, tick, past.get(part), same[part])
            last = tick

    def _take(self, part: str, tick: Tick, past: PartCommand | None, same: int) -> None:
        mode = tick.commands[part].mode
        if mode in TARGETS or mode is ControlMode.CARTESIAN_POSE:
            for what, distance in distances(self._driven, part, tick):
                lags = self.lags.setdefault((part, mode.yaml_name, what), {})
                lags[tick.kind] = max(lags.get(tick.kind, 0.0), distance)
        elif mode in (*_MOVING, ControlMode.JOINT_VELOCITY):
            for answer in answers(self._driven, part, tick):
                key = (part, mode.yaml_name, answer.what)
                before = None if past is None else past.values[answer.at]
                self.tracks.setdefault(key, {}).setdefault(tick.kind, Track()).samples.append(
                    Sample(answer.told, answer.moved, before, answer.started_at, same)
                )


def _is_same(part: str, past: Mapping[str, PartCommand], now: Mapping[str, PartCommand]) -> bool:
    return part in past and np.array_equal(past[part].values, now[part].values)


_MOVING = (ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST, ControlMode.BODY_TWIST)
