"""Rows at random, at full scale or creeping; with what the composite switch does beside them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from bench.soundness.adversary import Adversary
from bench.soundness.attack import ROWS_MOST, Parts, everything, some_mode
from bench.soundness.chunk_rows import Row
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment

Switch = Literal["up", "down", "flicker"]


class Wandering:
    """What the `Adversary` of judged chunks does, for one episode in one direction or none."""

    def __init__(self, robot: RobotManifest, rng: np.random.Generator, kind: str) -> None:
        self.ticks, self.claims = 150, everything(robot)
        self._adversary = Adversary(robot, [], rng)
        self._adversary.begin(kind)

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """As `Attack.chunk`."""
        return self._adversary.chunk(now)

    def answered(self, source: str, row: Row | None) -> None:
        """As `Attack.answered`."""
        self._adversary.go_on_after(row)


class FullScale:
    """Every arm, and at times what carries it, by random corners and directions of full scale.

    A direction lasts for 1 to 12 rows; after a refusal the next is gentler. Where the robot has a
    composite switch it is up, down, or flickers from row to row.
    """

    def __init__(
        self, robot: RobotManifest, rng: np.random.Generator, switch: Switch | None = None
    ) -> None:
        self.ticks, self.claims = 250, everything(robot)
        self._rng, self._switch = rng, switch
        modes = {}
        for part in robot.parts:
            if part.name == "composite":
                modes[part.name] = ControlMode.COMPOSITE_MODE
            elif len(part.joints) > 3 or rng.random() < 0.5:
                modes[part.name] = some_mode(robot, part.name, rng)
        self._parts, self._names = Parts(robot, modes), tuple(modes)
        self._wishes: dict[str, FloatArray] = {}
        self._left, self._lasts, self._scale = 0, int(rng.integers(1, 13)), 1.0

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """As `Attack.chunk`."""
        count = int(self._rng.integers(1, ROWS_MOST + 1))
        return [self._parts.row(self._next(), now) for _ in range(count)]

    def answered(self, source: str, row: Row | None) -> None:
        """As `Attack.answered`."""
        self._scale = 0.6 * self._scale if row is None else 1.0
        if row is None:
            self._left = 0
        self._parts.go_on_after(row)

    def _next(self) -> dict[str, FloatArray]:
        if self._left == 0:
            self._left = self._lasts
            self._wishes = {part: self._wish(part) for part in self._names}
        self._left -= 1
        wishes = dict(self._wishes)
        if "composite" in wishes:
            up = self._rng.random() < 0.5 if self._switch == "flicker" else self._switch == "up"
            wishes["composite"] = np.array([1.0 if up else -1.0])
        return wishes

    def _wish(self, part: str) -> FloatArray:
        axes = self._parts.axes(part)
        if self._rng.random() < 0.5:
            return self._scale * np.where(self._rng.random(axes) < 0.5, -1.0, 1.0)
        return self._scale * self._rng.uniform(-1.0, 1.0, axes)
