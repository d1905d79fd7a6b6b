"""G021 to G023: from where the robot is and from what acts, and from row to row."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from bench.equipment.case import ActedRow, Before, Measured, PartRows
from fairlead.messages import FloatArray
from tests.differential.absolute import norm
from tests.differential.changes import change_faults
from tests.differential.fault import Fault, above
from tests.differential.gate_file import JOINT_MODES, MODES, GateFile
from tests.differential.poses import pose_jumps


def step_faults(
    file: GateFile, measured: Measured, before: Before, rows: PartRows, row: int, first_row: int
) -> Iterator[Fault]:
    """The jump into one row of one part."""
    yield from change_faults(file, measured, before, rows, row, first_row)
    acted = before.get(rows.part)
    is_switch = acted is not None and (acted.mode, acted.frame) != (rows.mode, rows.frame)
    if MODES[rows.mode] == "gripper_binary":
        return  # "Any switch is legal by declaration."
    if MODES[rows.mode] == "cartesian_pose":
        last_pose = None if is_switch else acted
        step = 22 if row > first_row else seam_code(acted)
        yield from pose_jumps(file, measured, rows, (row, first_row, step), last_pose)
    elif row > first_row:
        last = rows.values[row - 1].tolist()
        yield from _jump(file, rows, row, (0, 22), dict(enumerate(last)), measured)
    else:
        known = {} if is_switch else _known(rows, acted)
        yield from _jump(file, rows, row, (21, seam_code(acted)), known, measured)


def seam_code(acted: ActedRow | None) -> int:
    """ "G023: the step from rows released and not yet executed", which no state has shown yet."""
    return 21 if acted is None or acted.is_measured else 23


def _known(rows: PartRows, acted: ActedRow | None) -> dict[int, float]:
    """Numbers of the row before by column; for a joint mode those of its active joints only."""
    if acted is None:
        return {}
    columns = acted.active if rows.mode in JOINT_MODES else range(len(acted.values))
    return {n: float(acted.values[n]) for n in columns}


def _jump(
    file: GateFile,
    rows: PartRows,
    row: int,
    codes: tuple[int, int],
    last: dict[int, float],
    measured: Measured,
) -> Iterator[Fault]:
    """codes: of the start from what is measured (0: a later row), of the step from ``last``."""
    block = file.parts[rows.part].modes[rows.mode]
    if rows.mode in JOINT_MODES:
        yield from _joint_jump(file, rows, row, codes, last, measured)
    elif "linear_step_limit" in block:
        yield from _norm_jump(file, rows, row, codes, last, measured)
    else:
        yield from _scalar_jump(file, rows, row, codes, last, measured)


def _joint_jump(
    file: GateFile,
    rows: PartRows,
    row: int,
    codes: tuple[int, int],
    last: dict[int, float],
    measured: Measured,
) -> Iterator[Fault]:
    """Joint by joint against the measurement, then against the row before.

    A velocity follows the row before alone, if there is one; a position starts near the measurement
    in either case, one step further where the row before is one that no state has shown yet.
    """
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    limits = dict(zip(part.joints, block["step_limit"], strict=True))
    rates = measured.velocities if MODES[rows.mode] == "joint_velocity" else None
    start, step = codes
    starts = []
    for index in rows.active if start else ():
        if rates is None:
            steps = 2.0 if step == 23 and index in last else 1.0
            room = steps * limits[index] + file.joints[index].tolerance
            starts.append((index, float(measured.positions[index]), room))
        elif index not in last:
            starts.append((index, float(rates[index]), limits[index]))
    yield from _changes(file, rows, row, start, starts)
    if start:
        yield from _left_out(file, rows, row, step, last)
    follows = [(index, last[index], limits[index]) for index in rows.active if index in last]
    yield from _changes(file, rows, row, step, follows)


def _changes(
    file: GateFile, rows: PartRows, row: int, code: int, starts: list[tuple[int, float, float]]
) -> Iterator[Fault]:
    """Joints whose row lies further than the limit from where it starts (joint, start, limit)."""
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    for index, start, limit in starts:
        size = abs(float(rows.values[row][index]) - start)
        if not size <= limit:
            where = (part.name, file.joints[index].name)
            yield above(code, row, where, size, limit, block["source"])


def _left_out(
    file: GateFile, rows: PartRows, row: int, step: int, last: dict[int, float]
) -> Iterator[Fault]:
    """Joints of the row before that this one does not command: told 0 as a velocity; with a target
    they may not be left out."""
    part, mode = file.parts[rows.part], MODES[rows.mode]
    block = part.modes[rows.mode]
    limits = dict(zip(part.joints, block["step_limit"], strict=True))
    for index in sorted(set(last) - set(rows.active)):
        where = (part.name, file.joints[index].name)
        if mode != "joint_velocity":
            why = "its target again, or a held tick"
            yield Fault(step, row, *where, source=why)
        elif not abs(last[index]) <= limits[index]:
            yield above(step, row, where, abs(last[index]), limits[index], block["source"])


def own_speeds(file: GateFile, part: int, velocities: FloatArray) -> FloatArray:
    """Only the part's own joints count: its twist comes on top of what other parts do."""
    own = np.zeros_like(velocities)
    joints = list(file.parts[part].joints)
    own[joints] = velocities[joints]
    return own


def _norm_jump(
    file: GateFile,
    rows: PartRows,
    row: int,
    codes: tuple[int, int],
    last: dict[int, float],
    measured: Measured,
) -> Iterator[Fault]:
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    start = list(last.values()) or _free_start(file, rows, measured)
    code = codes[1] if last else codes[0]
    now = rows.values[row].tolist()
    change = [a - b for a, b in zip(now, start, strict=True)]
    for axis, three in (("linear", change[:3]), ("angular", change[3:])):
        size, limit = norm(three), block[f"{axis}_step_limit"]
        if not size <= limit:
            yield above(code, row, (part.name, axis), size, limit, block["source"])


def _free_start(file: GateFile, rows: PartRows, measured: Measured) -> list[float]:
    """ "for a twist the base's, turned from odom into base_link by the measured yaw, deltas with
    zero". The base's is that of base_link's origin, which swings about the yaw axis."""
    if MODES[rows.mode] == "cartesian_delta":
        return [0.0] * 6
    if MODES[rows.mode] == "cartesian_twist":
        tool = file.parts[rows.part].tool
        assert tool is not None
        q, v = measured.positions, own_speeds(file, rows.part, measured.velocities)
        return list(file.kinematics.twist(q, v, tool, rows.frame).tolist())
    x, y, yaw = file.parts[rows.part].joints
    angle = float(measured.positions[yaw])
    vx, vy = float(measured.velocities[x]), float(measured.velocities[y])
    cos, sin = math.cos(angle), math.sin(angle)
    rate, (ahead, aside) = float(measured.velocities[yaw]), file.yaw_axis
    swing_x, swing_y = rate * aside, -rate * ahead
    return [cos * vx + sin * vy + swing_x, -sin * vx + cos * vy + swing_y, 0.0, 0.0, 0.0, rate]


def _scalar_jump(
    file: GateFile,
    rows: PartRows,
    row: int,
    codes: tuple[int, int],
    last: dict[int, float],
    measured: Measured,
) -> Iterator[Fault]:
    """A gripper starts from its measured opening, as a joint does; of a composite mode nothing is
    measured."""
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    limit = float(block["step_limit"])
    axis = "composite" if MODES[rows.mode] == "composite_mode" else "opening"
    starts = []
    if codes[0] and part.joints:
        (index,) = part.joints
        room = (2.0 if last and codes[1] == 23 else 1.0) * limit + file.joints[index].tolerance
        starts.append((codes[0], float(measured.positions[index]), room))
    if last:
        starts.append((codes[1], last[0], limit))
    for code, start, most in starts:
        size = abs(float(rows.values[row][0]) - start)
        if not size <= most:
            yield above(code, row, (part.name, axis), size, most, block["source"])
