"""G007, G008, G009: the shape of a chunk, past rows included."""

from __future__ import annotations

import math
from collections.abc import Iterator

from bench.equipment.case import Chunk, PartRows
from tests.differential.fault import Fault, above, below
from tests.differential.gate_file import (
    FRAMED_MODES,
    JOINT_MODES,
    MODES,
    NO_CHECKER,
    ROWS_MAX,
    GateFile,
)

TICK_MAX = 2**64 - 1
MAGNITUDE_MAX = 1e6
AXES = ("x", "y", "z", "rx", "ry", "rz")


def shape_fault(file: GateFile, horizon_max: int, chunk: Chunk) -> Fault | None:
    """The first thing wrong with the shape, by code."""
    checks = (
        _horizon(horizon_max, chunk),
        _widths(file, chunk),
        _ticks(chunk),
        _numbers(file, chunk),
        _commands(file, chunk),
    )
    for faults in checks:
        for fault in faults:
            return fault
    return None


def _horizon(horizon_max: int, chunk: Chunk) -> Iterator[Fault]:
    """ "G007 horizon, width of every mode, ticks of all rows within 64 bits"."""
    if chunk.horizon < 1:
        yield Fault(7, -1, "", "horizon", 0.0, 1.0, -1.0, "a chunk has at least one row")
    if chunk.horizon > min(horizon_max, ROWS_MAX):
        limit = min(horizon_max, ROWS_MAX)
        yield above(7, -1, ("", "horizon"), chunk.horizon, limit, "the claim's horizon_max")
    if not chunk.parts:
        yield Fault(7, -1, "", "parts", 0.0, 0.0, 0.0, "at least one part")


def _has_checker(rows: PartRows) -> bool:
    """A mode without a checker has no width: nothing of it is measured or read."""
    return rows.mode < len(MODES) and rows.mode not in NO_CHECKER


def _widths(file: GateFile, chunk: Chunk) -> Iterator[Fault]:
    for rows in filter(_has_checker, chunk.parts):
        name = file.parts[rows.part].name
        expected = chunk.horizon * file.width(rows.mode)
        if rows.values.size != expected:
            text = "horizon x width of the mode"
            yield Fault(7, -1, name, "values", rows.values.size, expected, 0.0, text)


def _ticks(chunk: Chunk) -> Iterator[Fault]:
    """ "ticks of all rows, and the one after the last, within 64 bits"."""
    if chunk.start_tick + chunk.horizon > TICK_MAX:
        text = "ticks that fit 64 bits, with the one after"
        yield Fault(7, -1, "", "start_tick", float(chunk.start_tick), 0.0, 0.0, text)


def _numbers(file: GateFile, chunk: Chunk) -> Iterator[Fault]:
    """ "G008 every value finite and at most 1e6", also beside a mode without a checker."""
    for rows in filter(_has_checker, chunk.parts):
        for row, values in enumerate(rows.values):
            for value in values.tolist():
                if not (math.isfinite(value) and abs(value) <= MAGNITUDE_MAX):
                    where = (file.parts[rows.part].name, MODES[rows.mode])
                    text = "every value is finite and at most 1e6"
                    if value < 0.0:
                        yield below(8, row, where, value, -MAGNITUDE_MAX, text)
                    else:
                        yield above(8, row, where, value, MAGNITUDE_MAX, text)


def _commands(file: GateFile, chunk: Chunk) -> Iterator[Fault]:
    """ "G009 mode known to the part, active joints its own, everything outside them exactly 0,
    no part twice"."""
    seen: set[int] = set()
    for rows in chunk.parts:
        part = file.parts[rows.part]
        if rows.part in seen:
            yield Fault(9, -1, part.name, "parts", 0.0, 0.0, 0.0, "each part at most once")
        seen.add(rows.part)
        if not _has_checker(rows):
            mode = MODES[rows.mode] if rows.mode < len(MODES) else "unknown"
            yield Fault(9, -1, part.name, mode, rows.mode, 0.0, 0.0, "a mode that has a checker")
            continue
        if rows.mode not in part.modes:
            text = "a mode this part declares"
            yield Fault(9, -1, part.name, MODES[rows.mode], rows.mode, 0.0, 0.0, text)
            continue
        checks = [_mask(file, rows), _frame(part.name, part.modes[rows.mode].get("frames"), rows)]
        for check in reversed(checks) if rows.mode in JOINT_MODES else checks:
            yield from check
        yield from _padding(file, rows)


def _frame(part: str, frames: list[str] | None, rows: PartRows) -> Iterator[Fault]:
    if rows.mode in FRAMED_MODES:
        if rows.frame not in (frames or ()):
            text = "a frame declared for this mode"
            yield Fault(9, -1, part, "frame_id", 0.0, 0.0, 0.0, text)
    elif rows.frame:
        text = "no frame in a joint mode" if rows.mode in JOINT_MODES else "no frame in this mode"
        yield Fault(9, -1, part, "frame_id", 0.0, 0.0, 0.0, text)


def _mask(file: GateFile, rows: PartRows) -> Iterator[Fault]:
    """`active`: "indices of the joints commanded, rising" (`fairlead.messages.ActionPart`)."""
    part = file.parts[rows.part]
    if rows.mode not in JOINT_MODES:
        if rows.active:
            text = "no mask but in a joint mode"
            yield Fault(9, -1, part.name, "active", 0.0, 0.0, 0.0, text)
        return
    if not rows.active:
        text = "the joints that it commands"
        yield Fault(9, -1, part.name, "active", 0.0, 0.0, 0.0, text)
    last = -1
    for joint in rows.active:
        if joint not in part.joints:
            axis = file.joints[joint].name if joint < len(file.joints) else "active"
            yield Fault(9, -1, part.name, axis, joint, 0.0, 0.0, "a joint of this part")
        if joint <= last:
            yield Fault(9, -1, part.name, "active", joint, last, 0.0, "ascending joints, each once")
        last = joint
    if len(file.turned_slides & {*rows.active}) == 1:
        text = "both slides of its base, or neither"
        yield Fault(9, -1, part.name, "active", 0.0, 0.0, 0.0, text)


def _padding(file: GateFile, rows: PartRows) -> Iterator[Fault]:
    """Joints that are not active, and axes that the base cannot do."""
    part = file.parts[rows.part]
    if rows.mode in JOINT_MODES:
        idle = [n for n in range(len(file.joints)) if n not in rows.active]
        names, text = [joint.name for joint in file.joints], "0.0 where not active"
    elif rows.mode == MODES.index("body_twist"):
        free = part.modes[rows.mode]["free_axes"]
        idle = [n for n in range(len(AXES)) if n not in free]
        names, text = list(AXES), "0.0 along an axis that is not free"
    else:
        return
    for row, values in enumerate(rows.values.tolist()):
        for axis in idle:
            if values[axis] != 0.0:
                yield Fault(9, row, part.name, names[axis], values[axis], 0.0, 0.0, text)
