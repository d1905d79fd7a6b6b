"""A second mind on what the gate does with one chunk, from its rules, not its code.

Nothing here was taken from the gate's code. It is written to be read, not to be fast.
"""

from __future__ import annotations

from dataclasses import dataclass

from bench.equipment.case import Before, Chunk, Measured, Pacing
from fairlead.messages import Outcome
from tests.differential.absolute import absolute_faults, blocked_part
from tests.differential.changes import left_out_faults
from tests.differential.fault import Fault, above
from tests.differential.gate_file import GateFile
from tests.differential.shape import shape_fault
from tests.differential.steps import step_faults

STOPPING = (8,)
"""Codes that also raise a stop."""


@dataclass(frozen=True)
class Ruling:
    """first_row, row_count: the rows released, as counted in the chunk; 0 rows if refused."""

    outcome: Outcome
    fault: Fault | None = None
    first_row: int = 0
    row_count: int = 0

    @property
    def stops(self) -> bool:
        return self.fault is not None and self.fault.code in STOPPING


def open_tick(pacing: Pacing, newest_tick: int) -> int:
    """The first tick that is not past: in realtime the HAL has used up the newest one."""
    return newest_tick if pacing == "lockstep" else newest_tick + 1


def judge(
    file: GateFile,
    horizon_max: int,
    open_from: int,
    measured: Measured,
    before: Before,
    chunk: Chunk,
) -> Ruling:
    """The ruling on a chunk of a live claim that covers every part.

    Args:
        file: with the claim's own limits in it.
        open_from: `open_tick`.
        before: what the parts did in the tick before the first live row.
    """
    fault = _protocol_fault(file, open_from, chunk) or shape_fault(file, horizon_max, chunk)
    if fault is None and chunk.start_tick + chunk.horizon - 1 < open_from:
        last = float(chunk.start_tick + chunk.horizon - 1)
        where = ("", "last row's tick")
        fault = below_tick(where, last, float(open_from))
    if fault is not None:
        return Ruling(Outcome.REFUSED, fault)
    return judge_rows(file, open_from, measured, before, chunk)


def below_tick(where: tuple[str, str], last: float, open_from: float) -> Fault:
    """ "G012 at least one row not yet past"."""
    return Fault(12, -1, *where, last, open_from, last - open_from, "the next open tick")


def _protocol_fault(file: GateFile, open_from: int, chunk: Chunk) -> Fault | None:
    for rows in chunk.parts:
        if rows.part >= len(file.parts):
            return Fault(4, -1, "", "part", rows.part, 0.0, 0.0, "a part of the claim")
    if chunk.start_tick > open_from:
        start, limit = float(chunk.start_tick), float(open_from)
        return above(6, -1, ("", "start_tick"), start, limit, "the next open tick")
    return None


def judge_rows(
    file: GateFile, open_from: int, measured: Measured, before: Before, chunk: Chunk
) -> Ruling:
    """ "Truncate keeps the rows before the one at fault; if it is the first, the chunk is
    refused" (docs/safety-checks.md, Checks). Past rows are dropped by their index, unjudged."""
    first = max(0, open_from - chunk.start_tick)
    for row in range(first, chunk.horizon):
        fault = row_fault(file, measured, before, chunk, row, first)
        if fault is None:
            continue
        if row == first:
            return Ruling(Outcome.REFUSED, fault)
        return Ruling(Outcome.TRUNCATED, fault, first, row - first)
    return Ruling(Outcome.RELEASED, None, first, chunk.horizon - first)


def row_fault(
    file: GateFile, measured: Measured, before: Before, chunk: Chunk, row: int, first: int
) -> Fault | None:
    """The first fault of one row: limits of all parts, then jumps of all parts, in the chunk's
    order."""
    for rows in chunk.parts:
        if row == first:
            for fault in blocked_part(file, measured, rows, row):
                return fault
        for fault in absolute_faults(file, measured, rows, row, first):
            return fault
    for rows in chunk.parts:
        for fault in step_faults(file, measured, before, rows, row, first):
            return fault
    if row == first:
        return next(left_out_faults(file, measured, before, chunk, row), None)
    return None


def has_stopped(file: GateFile, measured: Measured, chunk: Chunk, ruling: Ruling) -> bool:
    """Whether a state stops the gate of which a chunk's first released row has acted or acts: "the
    rows that act next do not lead back", from where the joint is measured now."""
    row = ruling.first_row + 1
    if ruling.row_count < 2:
        return False
    for rows in chunk.parts:
        faults = absolute_faults(file, measured, rows, row, row)
        blocked = [*blocked_part(file, measured, rows, row), *faults]
        if any(fault.code == 11 for fault in blocked):
            return True
    return False


NOT_ARMED = Ruling(Outcome.REFUSED, Fault(3, -1, "", "state", 0.0, 0.0, 0.0, "an armed gate"))
"""What a chunk is told after a stop."""
