"""The seam between two answers, where a skill says ``seam``: rows that go from one to the other.

Pure arithmetic, in realtime only: in lockstep no row is left when a policy answers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.messages import ActionPart, FloatArray, floats, pack_floats
from fairlead.modes import ControlMode
from fairlead_skill_runner.control_rows import turned

_BLENDED = frozenset({
    ControlMode.JOINT_POSITION, ControlMode.JOINT_VELOCITY, ControlMode.CARTESIAN_POSE,
    ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST, ControlMode.BODY_TWIST,
})  # fmt: skip
"""Half closed is neither open nor closed: grippers, hands and switches change at once."""

SPARE_TICKS = 1
"""What a lost message costs: the gate may release a chunk so much later than it was sent."""


@dataclass(frozen=True)
class ReleasedRows:
    """Rows that act now and next.

    parts: as they were sent, a row for each tick from ``start_tick``.
    last_tick: of the last released one.
    """

    parts: tuple[ActionPart, ...]
    start_tick: int
    last_tick: int

    def alike(self, part: ActionPart) -> ActionPart | None:
        """The rows of the same part in the same mode and frame, for the same joints."""
        for one in self.parts:
            if msgspec.structs.replace(one, values=part.values) == part:
                return one
        return None

    def at(self, part: ActionPart, width: int, ticks: npt.NDArray[np.int64]) -> FloatArray:
        """Rows of one of the parts; after the last one, that one: ``[n, width]``."""
        rows = floats(part.values, width)[: self.last_tick - self.start_tick + 1]
        return rows[np.clip(ticks - self.start_tick, 0, len(rows) - 1)]


def held_rows(parts: Iterable[ActionPart], positions: FloatArray, tick: int) -> ReleasedRows:
    """What joints that hold do, for the parts of an answer that gives them targets: a row each.

    Without it a policy that is late could never begin: its rows for the ticks that passed are
    gone, and the next one is not where the robot stands.

    Args:
        positions: of the commanded joints at ``tick`` [rad or m].
    """
    made = []
    for part in parts:
        if part.mode == ControlMode.JOINT_POSITION:
            row = np.zeros(len(positions))
            row[list(part.active)] = positions[list(part.active)]
            made.append(msgspec.structs.replace(part, values=pack_floats(row)))
    return ReleasedRows(tuple(made), tick, tick)


@dataclass(frozen=True)
class Seam:
    """Where one answer goes over to the next.

    before: released rows, or `held_rows`. now_tick: the newest one. blend_ticks: how many are
        between both.
    """

    before: ReleasedRows
    now_tick: int
    blend_ticks: int

    def blended(
        self, parts: Iterable[ActionPart], widths: Iterable[int], start_tick: int
    ) -> tuple[ActionPart, ...]:
        """An answer's rows, of which the first lead over from the released ones.

        Row k (from 1) of ``blend_ticks`` is k / (blend_ticks + 1) of the way from the released
        row of its tick, or the last one, to the answer's. The first is that of the second tick
        that is to come, so that no step is made where a message is lost; all before it are the
        released ones.

        Args:
            parts: a row for each tick from ``start_tick``.
            widths: numbers of a row, part by part.
        """
        made = []
        for part, width in zip(parts, widths, strict=True):
            mode, earlier = ControlMode(part.mode), self.before.alike(part)
            if mode in _BLENDED and earlier is not None:
                new = floats(part.values, width)
                ticks = start_tick + np.arange(len(new))
                rows = self._mixed(self.before.at(earlier, width, ticks), new, ticks, mode)
                part = msgspec.structs.replace(part, values=pack_floats(rows))
            made.append(part)
        return tuple(made)

    def _mixed(
        self, old: FloatArray, new: FloatArray, ticks: npt.NDArray[np.int64], mode: ControlMode
    ) -> FloatArray:
        share = (ticks - self.now_tick - SPARE_TICKS) / (self.blend_ticks + 1)
        share = np.clip(share, 0.0, 1.0)[:, None]
        made: FloatArray = old + share * (new - old)
        if mode is ControlMode.CARTESIAN_POSE:
            made[:, 3:] = turned(old[:, 3:], new[:, 3:], share)
        # To the bit where nothing is mixed.
        return np.where(share == 0.0, old, np.where(share == 1.0, new, made))
