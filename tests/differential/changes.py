"""G025: when a part may be told in another mode or frame, and a composite switch may turn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from bench.equipment.case import ActedRow, Before, Chunk, Measured, PartRows
from tests.differential.fault import Fault, above
from tests.differential.gate_file import MODES, GateFile

LISTED = "a change in its transitions"
STILL = "standstill, to change mode or frame"
UNMEASURED = "standstill after a held tick"
TURN = "standstill, to turn the composite switch"
TURN_UNMEASURED = UNMEASURED
LEFT_OUT = "composite left out"
COMPOSITE = MODES.index("composite_mode")
TURN_LATER = "a first row, and standstill"


def change_faults(
    file: GateFile, measured: Measured, before: Before, rows: PartRows, row: int, first_row: int
) -> Iterator[Fault]:
    """What one row of one part may not change."""
    if row > first_row:
        yield from _later_turn(file, rows, row)
        return
    acted = before.get(rows.part)
    if acted is None:
        # "Down below zero, or where a row that acts leaves it out"; "after arming nothing is known
        # and any mode may start".
        others = next(iter(before.values()), None)
        if others is not None and _turns(file, rows, -1.0, float(rows.values[row][0])):
            yield from _turn(file, measured, others, rows, row)
        return
    if (acted.mode, acted.frame) != (rows.mode, rows.frame):
        yield from _other_mode(file, measured, acted, rows, row)
    elif _turns(file, rows, float(acted.values[0]), float(rows.values[row][0])):
        yield from _turn(file, measured, acted, rows, row)


def left_out_faults(
    file: GateFile, measured: Measured, before: Before, chunk: Chunk, row: int
) -> Iterator[Fault]:
    """What the first row may not leave out: "where a row leaves the switch out, it is down"."""
    told = {rows.part for rows in chunk.parts}
    for index, part in enumerate(file.parts):
        block = part.modes.get(COMPOSITE)
        acted = before.get(index)
        if index in told or block is None or block["switching"] == "anywhere" or acted is None:
            continue
        if float(acted.values[0]) < 0.0:
            continue
        if acted.is_measured:
            yield from moving(file, measured, range(len(file.parts)), (row, part.name), TURN)
        else:
            yield Fault(25, row, part.name, LEFT_OUT, -1.0, 0.0, 0.0, TURN_UNMEASURED)


def _other_mode(
    file: GateFile, measured: Measured, acted: ActedRow, rows: PartRows, row: int
) -> Iterator[Fault]:
    """ "Only as its transitions list", and "at standstill only"; another frame of the same mode
    needs no entry."""
    part = file.parts[rows.part]
    is_listed = acted.mode == rows.mode or (acted.mode, rows.mode) in part.transitions
    if not is_listed:
        yield Fault(25, row, part.name, "mode", rows.mode, acted.mode, 0.0, LISTED)
    if acted.is_measured:
        yield from moving(file, measured, [rows.part], (row, part.name), STILL)
    else:
        yield Fault(25, row, part.name, "mode", rows.mode, acted.mode, 0.0, UNMEASURED)


def moving(
    file: GateFile,
    measured: Measured,
    parts: Iterable[int],
    where: tuple[int, str],
    rule: str,
) -> Iterator[Fault]:
    """Standstill: "every joint of the part is below its declared standstill_velocity", by its
    velocity and by its positions. where: the row, and the part that asks."""
    row, name = where
    for part in parts:
        for index in file.parts[part].joints:
            joint, speed = file.joints[index], speed_of(file, measured, index)
            if not speed < joint.standstill:
                yield above(25, row, (name, joint.name), speed, joint.standstill, rule)


def speed_of(file: GateFile, measured: Measured, index: int) -> float:
    """What the velocity says, or the way from the tick before beyond the encoder's step, if that
    is more."""
    speed = abs(float(measured.velocities[index]))
    if measured.came_from is None:
        return speed
    joint, way = file.joints[index], float(measured.positions[index] - measured.came_from[index])
    way = math.remainder(way, math.tau) if joint.turns else way
    return max(speed, (abs(way) - joint.encoder_step) / file.period_s)


def _turns(file: GateFile, rows: PartRows, last: float, now: float) -> bool:
    """ "Its number changes its sign (zero counts as not below zero)", where that matters."""
    block = file.parts[rows.part].modes[rows.mode]
    is_bound = MODES[rows.mode] == "composite_mode" and block["switching"] != "anywhere"
    return is_bound and (last < 0.0) != (now < 0.0)


def _turn(
    file: GateFile, measured: Measured, acted: ActedRow, rows: PartRows, row: int
) -> Iterator[Fault]:
    """ "While every part of the claim stands still"; every case claims all of them."""
    name = file.parts[rows.part].name
    if acted.is_measured:
        yield from moving(file, measured, range(len(file.parts)), (row, name), TURN)
    else:
        value = float(rows.values[row][0])
        yield Fault(25, row, name, "composite", value, 0.0, 0.0, TURN_UNMEASURED)


def _later_turn(file: GateFile, rows: PartRows, row: int) -> Iterator[Fault]:
    last, now = float(rows.values[row - 1][0]), float(rows.values[row][0])
    if _turns(file, rows, last, now):
        yield Fault(25, row, file.parts[rows.part].name, "composite", now, last, 0.0, TURN_LATER)
