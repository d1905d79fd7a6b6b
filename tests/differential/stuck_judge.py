"""G041: what joints were told to move since they last moved, from docs/safety-checks.md alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fairlead.messages import FloatArray
from tests.differential.case import Measured


@dataclass
class ToldMotion:
    """What somebody was told since the last change: rows that told it, and how far at most."""

    rows: int = 0
    total: FloatArray = field(default_factory=lambda: np.zeros(6))
    furthest: float = 0.0

    def add(self, motion: FloatArray) -> None:
        """A motion of a row: linear and angular [m, rad]. None at all tells nothing."""
        if not np.any(motion):
            return
        self.rows += 1
        self.total = self.total + motion
        halves = (self.total[:3], self.total[3:])
        self.furthest = max(self.furthest, *(float(np.linalg.norm(half)) for half in halves))

    def add_left(self, dead_band: float, *left: float) -> None:
        """What is left to a target; within the dead band it tells nothing."""
        if max(left) > dead_band:
            self.rows += 1
            self.furthest = max(self.furthest, *left)


@dataclass
class StuckJudge:
    """One part's joints. steps, dead_bands: by joint of the robot."""

    joints: Sequence[int]
    steps: dict[int, float]
    dead_bands: dict[int, float]
    rows_to_stop: int
    rest: FloatArray | None = None
    by_joint: dict[int, ToldMotion] = field(default_factory=dict)
    by_part: ToldMotion = field(default_factory=ToldMotion)
    changed: frozenset[int] = frozenset()

    def note(self, last: Measured, now: Measured) -> None:
        """ "Only a measured change begins anew", counted from where the joint last rested."""
        if self.rest is None:
            self.rest = last.positions.copy()
        moved = np.abs(now.positions - self.rest)
        self.changed = frozenset(j for j in self.joints if moved[j] > self.steps[j])
        for j in self.changed:
            self.rest[j] = now.positions[j]
            self.by_joint.pop(j, None)
        if self.changed:
            self.by_part = ToldMotion()

    def told_to_joint(self, j: int, motion: float) -> int | None:
        """A velocity's share of a tick [rad or m]. Returns the joint if that stops."""
        told = self.by_joint.setdefault(j, ToldMotion())
        if j not in self.changed:
            told.add(np.array([motion, 0.0, 0.0, 0.0, 0.0, 0.0]))
        return self._stops(told, j)

    def target_of_joint(self, j: int, left: float) -> int | None:
        """What is left to a target [rad or m]."""
        told = self.by_joint.setdefault(j, ToldMotion())
        if j not in self.changed:
            told.add_left(self.dead_bands[j], left)
        return self._stops(told, j)

    def told_to_part(self, motion: FloatArray) -> int | None:
        """A share of a delta or twist, in one tick. Returns the part's first joint if it stops."""
        if not self.changed:
            self.by_part.add(motion)
        return self._part_stops()

    def pose_of_part(self, distance: float, angle: float) -> int | None:
        """What is left to a pose [m, rad]."""
        if not self.changed:
            self.by_part.add_left(self._part_band(), distance, angle)
        return self._part_stops()

    def _part_band(self) -> float:
        return max((self.dead_bands[j] for j in self.joints), default=math.inf)

    def _stops(self, told: ToldMotion, j: int) -> int | None:
        beyond = told.rows >= self.rows_to_stop and told.furthest > self.dead_bands[j]
        return j if beyond and j not in self.changed else None

    def _part_stops(self) -> int | None:
        enough = self.by_part.rows >= self.rows_to_stop
        beyond = enough and self.by_part.furthest > self._part_band()
        return self.joints[0] if beyond and not self.changed else None
