"""The tracking model of each mode: gains, residuals and lags over many ticks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import nnls

from bench.measure_limits.driven_robot import DrivenRobot, Tick
from bench.measure_limits.motion import answers, distances
from bench.measure_limits.rows import TARGETS
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode

STEADY_TICKS = 8
"""Ticks of the same row after which the motion counts as steady."""
FULL_SHARE = 0.5
"""Of the largest row seen: below it a share says little, and is left out."""

Range = tuple[float, float]


_ONE = 1e4
"""Weight of the rule that shares of a hull's corners add up to 1."""


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

    def beyond(self, gain: Range) -> float:
        """Distance to everything between the row before and the gain's share of this one."""
        now = [share * self.told for share in gain]
        if self.before is None:
            past = [np.zeros_like(self.told), self.started_at]
        else:
            past = [share * self.before for share in gain]
        return max(distance_to_hull(way, [*past, *now]) for way in self.moved)


def distance_to_hull(point: FloatArray, corners: list[FloatArray]) -> float:
    """From a point to the nearest mixture of the corners."""
    scale = max(float(np.abs(corners).max()), float(np.abs(point).max()), 1e-9)
    matrix = np.vstack([np.array(corners).T / scale, np.full(len(corners), _ONE)])
    shares, _ = nnls(matrix, np.append(point / scale, _ONE))
    return float(np.linalg.norm(np.array(corners).T @ shares - point))


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
        return max((sample.beyond(gain) for sample in self.samples), default=0.0)


class TrackingModel:
    """Tracks by (part, mode, half or joint) and kind of drive; lags of targets likewise."""

    def __init__(self, driven: DrivenRobot) -> None:
        self._driven = driven
        self.tracks: dict[tuple[str, str, str], dict[str, Track]] = {}
        self.lags: dict[tuple[str, str, str], dict[str, float]] = {}

    def take(self, ticks: Iterable[Tick]) -> None:
        """Ticks of one drive; those in contact count in demonstrations only."""
        last: Tick | None = None
        same: dict[str, int] = {}
        for tick in ticks:
            follows = last is not None and last.after is tick.before
            past = last.commands if last is not None and follows else {}
            for part in tick.commands:
                same[part] = same.get(part, 0) + 1 if _is_same(part, past, tick.commands) else 0
                if tick.is_free or tick.kind == "oracle":
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
