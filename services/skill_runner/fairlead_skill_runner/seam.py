"""The seam between two answers, where a skill says ``seam``: rows that go from one to the other.

Pure arithmetic, in realtime only: in lockstep no row is left when a policy answers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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

_TARGETS = frozenset({
    ControlMode.JOINT_POSITION, ControlMode.GRIPPER_POSITION, ControlMode.GRIPPER_BINARY,
    ControlMode.DEX_HAND_JOINT, ControlMode.COMPOSITE_MODE,
})  # fmt: skip
"""Their rows say where to be, so that they may come later: motions would be done a second time."""

SPARE_TICKS = 1
"""What a lost message costs: the gate may release a chunk so much later than it was sent."""


@dataclass(frozen=True)
class ReleasedRows:
    """Rows that act now and next.

    parts: as they were sent, a row for each tick from ``start_tick``.
    last_tick: of the last released one.
    hold: they are no rows, but where joints hold.
    """

    parts: tuple[ActionPart, ...]
    start_tick: int
    last_tick: int
    hold: bool = False

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
    return ReleasedRows(tuple(made), tick, tick, hold=True)


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

        Joints that hold have not done the rows of the ticks that passed: all targets of the answer
        come so much later that they begin with the row nearest to where the joints are. What is
        left of the way there is spread likewise.

        Args:
            parts: a row for each tick from ``start_tick``.
            widths: numbers of a row, part by part.
        """
        answer = [
            (part, floats(part.values, width)) for part, width in zip(parts, widths, strict=True)
        ]
        late = self._ticks_late(answer, start_tick) if self.before.hold else 0
        return tuple(self._led_over(part, rows, start_tick, late) for part, rows in answer)

    def _led_over(
        self, part: ActionPart, new: FloatArray, start_tick: int, late: int
    ) -> ActionPart:
        mode, earlier = ControlMode(part.mode), self.before.alike(part)
        new = new[np.maximum(np.arange(len(new)) - late, 0)]
        if mode in _BLENDED and earlier is not None:
            ticks = start_tick + np.arange(len(new))
            old, share = self.before.at(earlier, new.shape[1], ticks), self._share(ticks)
            if self.before.hold:  # then they move as the answer does
                first = self._first(ticks)
                old[first:] += new[first:] - new[first]
                lowest, highest = np.minimum(old[0], new.min(0)), np.maximum(old[0], new.max(0))
                new = np.clip(self._mixed(old, new, share, mode), lowest, highest)
            else:
                new = self._mixed(old, new, share, mode)
        elif not late:
            return part
        return msgspec.structs.replace(part, values=pack_floats(new))

    def _first(self, ticks: npt.NDArray[np.int64]) -> int:
        """The first of the ticks in which the answer counts, by its place."""
        return int(np.clip(self.now_tick + SPARE_TICKS + 1 - ticks[0], 0, len(ticks) - 1))

    def _ticks_late(self, answer: Sequence[tuple[ActionPart, FloatArray]], start_tick: int) -> int:
        """By how much its rows come later; by 0 where one of them is a motion, not a target.

        By 0, too, where a number is not finite: no row is left out that the gate would refuse.
        """
        if not all(
            ControlMode(part.mode) in _TARGETS and np.isfinite(new).all() for part, new in answer
        ):
            return 0
        away = np.zeros(0)
        for part, new in answer:
            held = self.before.alike(part)
            if held is not None:
                first = self._first(start_tick + np.arange(len(new)))
                distances = np.abs(new[: first + 1] - floats(held.values, new.shape[1]))
                away = np.maximum(distances.max(axis=1), away if len(away) else 0.0)
        return int(np.argmin(away[::-1])) if len(away) else 0  # of equal rows the last

    def _share(self, ticks: npt.NDArray[np.int64]) -> FloatArray:
        """How far each tick's row is from the earlier to the answer's: ``[n, 1]``."""
        share = (ticks - self.now_tick - SPARE_TICKS) / (self.blend_ticks + 1)
        return np.clip(share, 0.0, 1.0)[:, None]

    def _mixed(
        self, old: FloatArray, new: FloatArray, share: FloatArray, mode: ControlMode
    ) -> FloatArray:
        made: FloatArray = old + share * (new - old)
        if mode is ControlMode.CARTESIAN_POSE:
            made[:, 3:] = turned(old[:, 3:], new[:, 3:], share)
        # To the bit where nothing is mixed.
        return np.where(share == 0.0, old, np.where(share == 1.0, new, made))
