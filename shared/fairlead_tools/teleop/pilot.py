"""From what a person asks for to rows: the decision of one tick, without clock or messages."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.drive import XYZ, Drive

NEARER = 0.3
"""Of what is left to a joint's limit, the most that one row goes on: it ends there at rest."""


@dataclass(frozen=True)
class _Row:
    """One row: what is sent, and the way it goes on from the row before, ``[n]`` each."""

    values: FloatArray
    speeds: FloatArray


class Pilot:
    """Plans a few rows from each tick on: what is asked for now, then to rest.

    A device, a process or a link that falls silent thus leaves rows that end at rest. The
    first row after a hold is where the robot is. Rows whose tick may have begun when they
    arrive repeat those of the plan before, so that it does not matter whether they do.

    Args:
        drive: what is driven.
        ahead: ticks whose rows may have acted when a new one arrives: 0 in lockstep, else 1.
        horizon: rows, at most.
        silence_s: a deflection is believed for so long [s].
    """

    def __init__(self, drive: Drive, *, ahead: int, horizon: int, silence_s: float) -> None:
        self._drive, self._ahead, self._silence_s = drive, ahead, silence_s
        to_rest = math.ceil(float(np.max(drive.full / drive.change)))
        self._count = min(horizon, ahead + 1 + to_rest)
        self._plan: dict[int, _Row] = {}
        self._proposed: dict[int, _Row] = {}
        self._acts_from = 0
        self.at_rest = True
        """Whether the newest row goes nowhere."""

    def rows(self, tick: int, measured: FloatArray, is_held: bool, asked: Deflection) -> FloatArray:
        """Rows ``[H, n]`` for ``tick`` and those after it.

        Args:
            measured: where each axis is [rad or m], ``[n]``; only targets are planned from it.
            is_held: whether the part held in the tick before.
        """
        if is_held and tick > self._acts_from:
            self._plan = {}
        last = tick + self._ahead - 1
        wanted = self._wanted(asked)
        if last in self._plan:
            rows = [self._plan[each] for each in range(tick, last + 1)]
            now = self._plan[last]
        else:
            still = np.zeros_like(measured)
            now = _Row(self._inside(measured) if self._drive.is_position else still, still)
            rows = [now] * max(1, self._ahead)
            wanted, self._acts_from = still, tick + self._ahead
        rows += list(self._onward(now, wanted, measured, self._count - len(rows)))
        self.at_rest = not rows[self._ahead].speeds.any()
        self._proposed = dict(enumerate(rows, tick))
        return np.array([row.values for row in rows])

    def judged(self, released_last: int) -> None:
        """Keep the rows proposed last up to the tick that the gate released; 0: none was."""
        if released_last:
            self._plan = {t: row for t, row in self._proposed.items() if t <= released_last}

    def commanded(self, tick: int, measured: FloatArray) -> FloatArray:
        """Where targets have come to by ``tick``; of speeds, where the robot is measured."""
        row = self._plan.get(tick + self._ahead - 1)
        return row.values if row is not None and self._drive.is_position else measured

    def _inside(self, measured: FloatArray) -> FloatArray:
        """A joint at its end stop may be measured a little beyond its limit."""
        inside: FloatArray = np.clip(measured, self._drive.lower, self._drive.upper)
        return inside

    def _wanted(self, asked: Deflection) -> FloatArray:
        """Speed per row along each axis: none without clutch, or where the device is silent."""
        drive = self._drive
        share = np.clip(np.array(asked.axes, dtype=np.float64), -1.0, 1.0)
        is_heard = asked.clutch and asked.age_s <= self._silence_s
        if not is_heard or not np.isfinite(share).all():
            return np.zeros(len(drive.names))
        if not drive.is_position:  # the gate limits norms
            linear = np.array([name in XYZ for name in drive.names])
            for group in (linear, ~linear):
                share[group] /= max(1.0, float(np.linalg.norm(share[group])))
        wanted: FloatArray = share * min(max(asked.speed, 0.0), 1.0) * drive.full
        return wanted

    def _onward(
        self, row: _Row, wanted: FloatArray, measured: FloatArray, count: int
    ) -> Iterator[_Row]:
        drive = self._drive
        room_up = np.maximum(measured + drive.lead - row.values, 0.0)
        room_down = np.minimum(measured - drive.lead - row.values, 0.0)
        for _ in range(count):
            more = np.clip(wanted - row.speeds, -drive.change, drive.change)
            speeds = row.speeds + more
            if drive.is_position:
                up = NEARER * np.maximum(drive.upper - row.values, 0.0)
                down = NEARER * np.minimum(drive.lower - row.values, 0.0)
                up, down = np.minimum(up, room_up), np.maximum(down, room_down)
                speeds = np.clip(speeds, down, up)
            row = _Row(row.values + speeds if drive.is_position else speeds, speeds)
            yield row
            wanted = np.zeros_like(wanted)
            room_up, room_down = room_up - speeds, room_down - speeds
