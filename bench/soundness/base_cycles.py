"""The base to and fro, a hundred times, under an arm that holds or is told deltas of zero."""

from __future__ import annotations

import numpy as np

from bench.soundness.attack import Parts, everything
from bench.soundness.chunk_rows import Row
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment

CYCLES = 100
TELLING = ("held", "zero", "ratchet")
APPROACH_REFUSED = 3
APPROACH_TICKS = 80


class BaseCycles:
    """First the arm goes to an edge of its workspace; then only the base is told to move.

    The arm meanwhile is ``held``, told ``zero`` all the time, or, as a ``ratchet``, told zero on
    the way out and held on the way back. The composite switch is at either end, or held. Where it
    was refused, the base goes on more slowly.
    """

    def __init__(self, robot: RobotManifest, rng: np.random.Generator) -> None:
        self.claims = everything(robot)
        self._telling = TELLING[int(rng.integers(len(TELLING)))]
        self._half = int(rng.integers(3, 9))
        self.ticks = APPROACH_TICKS + 2 * CYCLES * self._half
        self._parts = Parts(
            robot,
            {
                "arm": ControlMode.CARTESIAN_DELTA,
                "base": ControlMode.JOINT_VELOCITY,
                "composite": ControlMode.COMPOSITE_MODE,
            },
        )
        self._switch = float(rng.choice([-1.0, 0.0, 1.0]))
        self._edge = np.zeros(6)
        self._edge[int(rng.integers(3))] = float(rng.choice([-1.0, 1.0]))
        self._way = np.where(rng.random(3) < 0.5, 0.0, np.sign(rng.uniform(-1.0, 1.0, 3)))
        self._way[int(rng.integers(3))] = float(rng.choice([-1.0, 1.0]))
        self._rows_most = int(rng.integers(1, 17))
        self._began: int | None = None
        self._scale, self._refused, self._speed = 1.0, 0, 1.0

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """As `Attack.chunk`."""
        if self._began is None and self._refused < APPROACH_REFUSED and tick < APPROACH_TICKS:
            return [self._parts.row({"arm": self._scale * self._edge}, now)] * 2
        if self._began is None:
            self._began = tick
        at = tick - self._began
        left = self._half - at % self._half
        out = (at // self._half) % 2 == 0
        wishes = self._wishes(out)
        return [self._parts.row(wishes, now) for _ in range(min(left, self._rows_most))]

    def answered(self, source: str, row: Row | None) -> None:
        """As `Attack.answered`."""
        if self._began is not None:
            self._speed = 0.5 * self._speed if row is None else min(1.0, 1.1 * self._speed)
        elif row is None:
            self._refused, self._scale = self._refused + 1, self._scale / 3.0
        self._parts.go_on_after(row)

    def _wishes(self, out: bool) -> dict[str, FloatArray]:
        wishes = {"base": self._speed * (self._way if out else -self._way)}
        if self._telling == "zero" or (self._telling == "ratchet" and out):
            wishes["arm"] = np.zeros(6)
        if self._switch:
            wishes["composite"] = np.array([self._switch])
        return wishes
