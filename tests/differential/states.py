"""Measured states: inside, at and beyond every bound and tolerance."""

from __future__ import annotations

import math

import numpy as np

from bench.equipment.case import Measured
from fairlead.messages import FloatArray
from tests.differential.gate_file import MODES, GateFile, Joint, Part

REACHES = 60
PERIOD_S = 0.05
ROOM = 3.0
"""Where a joint without bounds may stand [m or rad]."""
FASTEST = 2.0
"""Of a quiet file's joints, too: what held in realtime is no further off than the walls [1/s]."""


class StateMaker:
    """Draws states of one robot."""

    def __init__(self, file: GateFile, rng: np.random.Generator) -> None:
        self._file = file
        self._joints = (*file.joints, *file.passive)
        self._rng = rng

    def draw(self, tick: int) -> Measured:
        """Somewhere; one joint in 20 at a bound or beyond it."""
        positions = np.array([self._position(joint) for joint in self._joints])
        for part in self._file.parts:
            if MODES.index("cartesian_pose") in part.modes and self._rng.random() < 0.7:
                self._reach_into_box(positions, part)
        return Measured(tick, positions, self._velocities(positions), self._efforts())

    def next(self, last: Measured) -> Measured:
        """The state one tick later, within what the robot can do; nothing moves so that it would
        be over a bound within two ticks more, as in `_velocities`."""
        reach = np.array([0.9 * joint.jump_limit for joint in self._joints])
        reach *= self._rng.choice([0.0, 0.01, 1.0])
        moved = last.positions + self._rng.uniform(-1.0, 1.0, len(reach)) * reach
        pairs = zip(self._joints, moved.tolist(), strict=True)
        moved = np.array([_not_within_tolerance(joint, position) for joint, position in pairs])
        most = 0.95 * np.array([joint.jump_limit for joint in self._joints])
        way = moved - last.positions
        lower = np.array([joint.lower for joint in self._joints])
        upper = np.array([joint.upper for joint in self._joints])
        over = (moved + 2.0 * way < lower) | (moved + 2.0 * way > upper)
        moved = np.where((np.abs(way) > most) | over, last.positions, moved)
        return Measured(last.tick + 1, moved, self._velocities(moved), self._efforts())

    def _reach_into_box(self, positions: FloatArray, part: Part) -> None:
        """Move the part's joints until its tool is inside the box of its poses, if that is soon."""
        block = part.modes[MODES.index("cartesian_pose")]
        assert part.tool is not None
        for _ in range(REACHES):
            place, _ = self._file.kinematics.pose(positions, part.tool, block["frames"][0])
            if np.all(place > block["lower"]) and np.all(place < block["upper"]):
                return
            for index in part.joints:
                joint = self._joints[index]
                positions[index] = self._rng.uniform(joint.lower, joint.upper)

    def _position(self, joint: Joint) -> float:
        rng = self._rng
        if math.isinf(joint.lower):
            return float(rng.uniform(-ROOM, ROOM))
        if rng.random() > 0.05:
            return float(rng.uniform(joint.lower, joint.upper))
        bound, sign = (joint.lower, -1.0) if rng.random() < 0.5 else (joint.upper, 1.0)
        edge = bound + sign * joint.tolerance * float(rng.choice([0.0, 1.0]))
        value = float(rng.choice([nudged(edge, rng), edge + sign * rng.uniform(0.0, 0.3)]))
        return _not_within_tolerance(joint, value)

    def _velocities(self, positions: FloatArray) -> FloatArray:
        """At rest, about to be at rest, or moving; never over a bound within two ticks, which G024
        refuses and the reference does not know."""
        drawn = self._any_velocities()
        lower = np.array([joint.lower for joint in self._joints])
        upper = np.array([joint.upper for joint in self._joints])
        slowest = np.minimum((lower - positions) / (2.0 * PERIOD_S), 0.0)
        fastest = np.maximum((upper - positions) / (2.0 * PERIOD_S), 0.0)
        return np.clip(drawn, slowest, fastest)

    def _any_velocities(self) -> FloatArray:
        rng = self._rng
        kind = rng.random()
        if kind < 0.4:
            return np.zeros(len(self._joints))
        still = np.array([joint.standstill for joint in self._joints])
        if kind < 0.7:
            sign = rng.choice([-1.0, 1.0], len(still))
            slow = np.where(rng.random(len(still)) < 0.9, 0.3 * still, still)
            slow = np.where(rng.random(len(still)) < 0.1, np.nextafter(still, 0.0), slow)
            return np.asarray(sign * slow, dtype=np.float64)
        top = np.array([np.nan_to_num(joint.velocity_limit, nan=0.1) for joint in self._joints])
        top = np.minimum(top, FASTEST)
        return np.asarray(rng.uniform(-1.2, 1.2, len(top)) * top, dtype=np.float64)

    def _efforts(self) -> FloatArray:
        top = np.array([np.nan_to_num(joint.effort_limit, nan=1.0) for joint in self._joints])
        return np.asarray(self._rng.uniform(-1.1, 1.1, len(top)) * top, dtype=np.float64)


def _not_within_tolerance(joint: Joint, position: float) -> float:
    """Never beyond a bound by less than the tolerance.

    From there G024 refuses what leads further out, which the reference does not know.
    """
    if joint.is_outside(position) or not joint.violation(position) > 0.0:
        return position
    return joint.upper if position > joint.upper else joint.lower


def nudged(value: float, rng: np.random.Generator) -> float:
    """The number, or one of its two neighbours."""
    return float(rng.choice([np.nextafter(value, -np.inf), value, np.nextafter(value, np.inf)]))
