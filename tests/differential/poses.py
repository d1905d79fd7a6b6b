"""Poses of a tool: inside a box, a unit quaternion, and no leap from where the tool is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bench.equipment.case import ActedRow, Measured, PartRows
from bench.equipment.kinematics import Pose, angle_between, rotation_of
from tests.differential.fault import Fault, above, below
from tests.differential.gate_file import GateFile

NORM_TOLERANCE = 1e-6


def pose_faults(file: GateFile, rows: PartRows, row: int) -> Iterator[Fault]:
    """Outside the box for the tool's origin, or "|norm - 1| <= 1e-6" does not hold."""
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    values = rows.values[row].tolist()
    sides = zip("xyz", values[:3], block["lower"], block["upper"], strict=True)
    for axis, value, lower, upper in sides:
        if value < lower:
            yield below(20, row, (part.name, axis), value, lower, block["source"])
        if value > upper:
            yield above(20, row, (part.name, axis), value, upper, block["source"])
    norm, where = float(np.linalg.norm(values[3:])), (part.name, "quaternion norm")
    if norm < 1.0 - NORM_TOLERANCE:
        yield below(20, row, where, norm, 1.0 - NORM_TOLERANCE, block["source"])
    if norm > 1.0 + NORM_TOLERANCE:
        yield above(20, row, where, norm, 1.0 + NORM_TOLERANCE, block["source"])


def pose_jumps(
    file: GateFile,
    measured: Measured,
    rows: PartRows,
    at: tuple[int, int, int],
    acted: ActedRow | None,
) -> Iterator[Fault]:
    """The distance and the angle to the measured pose of the tool, and to the row before.

    A step; from the measured pose one more where no state has shown that row yet.

    at: row, first live row, code of the step from the row before.
    """
    row, first, step = at
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    now = _pose(rows.values[row].tolist())
    starts = []
    if row > first:
        starts.append((step, _pose(rows.values[row - 1].tolist()), 1.0))
    else:
        assert part.tool is not None
        here = file.kinematics.pose(measured.positions, part.tool, rows.frame)
        starts.append((21, here, 2.0 if acted is not None and step == 23 else 1.0))
        if acted is not None:
            starts.append((step, _pose(acted.values.tolist()), 1.0))
    for code, start, steps in starts:
        far = float(np.linalg.norm(now[0] - start[0]))
        turned = angle_between(now[1], start[1])
        for axis, size in (("linear", far), ("angular", turned)):
            limit = steps * block[f"{axis}_step_limit"]
            if not size <= limit:
                yield above(code, row, (part.name, axis), size, limit, block["source"])


def _pose(values: list[float]) -> Pose:
    return np.array(values[:3]), rotation_of(np.array(values[3:]))
