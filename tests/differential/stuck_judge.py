"""G041: what joints were told to move since they last moved, from its rules, not its code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.equipment.case import Measured
from fairlead.messages import FloatArray

Halves = tuple[float, float]
"""Linear [m] and angular [rad]; of one joint the first, in its own unit."""


@dataclass
class ToldMotion:
    """What somebody was told since the last change: rows that told it, and how far at most."""

    rows: int = 0
    total: FloatArray = field(default_factory=lambda: np.zeros(6))
    furthest: Halves = (0.0, 0.0)

    def add(self, motion: FloatArray) -> None:
        """A motion of a row: linear and angular [m, rad]. None at all tells nothing."""
        if not np.any(motion):
            return
        self.rows += 1
        self.total = self.total + motion
        self._reach((float(np.linalg.norm(self.total[:3])), float(np.linalg.norm(self.total[3:]))))

    def add_left(self, dead_band: Halves, left: Halves) -> None:
        """What is left to a target; within the dead band it tells nothing."""
        if left[0] > dead_band[0] or left[1] > dead_band[1]:
            self.rows += 1
            self._reach(left)

    def is_beyond(self, dead_band: Halves) -> bool:
        """Either half further than its own."""
        return self.furthest[0] > dead_band[0] or self.furthest[1] > dead_band[1]

    def _reach(self, far: Halves) -> None:
        self.furthest = max(self.furthest[0], far[0]), max(self.furthest[1], far[1])


@dataclass
class StuckJudge:
    """One part's joints. steps, dead_bands: by joint of the robot. part_band: of its tool or of
    the whole base."""

    joints: Sequence[int]
    steps: dict[int, float]
    dead_bands: dict[int, float]
    part_band: Halves
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
            told.add_left((self.dead_bands[j], 0.0), (left, 0.0))
        return self._stops(told, j)

    def told_to_part(self, motion: FloatArray) -> int | None:
        """A share of a delta or twist, in one tick. Returns the part's first joint if it stops."""
        if not self.changed:
            self.by_part.add(motion)
        return self._part_stops()

    def pose_of_part(self, distance: float, angle: float) -> int | None:
        """What is left to a pose [m, rad]."""
        if not self.changed:
            self.by_part.add_left(self.part_band, (distance, angle))
        return self._part_stops()

    def _stops(self, told: ToldMotion, j: int) -> int | None:
        beyond = told.rows >= self.rows_to_stop and told.is_beyond((self.dead_bands[j], 0.0))
        return j if beyond and j not in self.changed else None

    def _part_stops(self) -> int | None:
        enough = self.by_part.rows >= self.rows_to_stop
        beyond = enough and self.by_part.is_beyond(self.part_band)
        return self.joints[0] if beyond and not self.changed else None
