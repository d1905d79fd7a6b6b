"""G011 on rows and G020: may the robot be told this at all?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from bench.equipment.case import Measured, PartRows
from tests.differential.fault import Fault, above, below
from tests.differential.gate_file import JOINT_MODES, MODES, Block, GateFile, Joint
from tests.differential.poses import pose_faults

TOWARDS = "a way back towards its bounds"


def norm(values: Sequence[float]) -> float:
    """Euclidean norm of three numbers."""
    x, y, z = values
    return math.sqrt(x * x + y * y + z * z)


def blocked_part(file: GateFile, measured: Measured, rows: PartRows, row: int) -> Iterator[Fault]:
    """A joint outside bounds and tolerance that these rows cannot be seen to lead back.

    "A cartesian row cannot be seen to lead back and is refused"; so is one that leaves the
    joint alone. Gripper targets are judged by their range.
    """
    part = file.parts[rows.part]
    for index in part.joints:
        joint, position = file.joints[index], float(measured.positions[index])
        if not joint.is_outside(position) or _leads_back(rows, index):
            continue
        limit = joint.upper if position > joint.upper else joint.lower
        margin = -joint.violation(position)
        text = "measured outside bounds + tolerance: only rows that reduce it"
        yield Fault(11, row, part.name, joint.name, position, limit, margin, text)


def _leads_back(rows: PartRows, joint: int) -> bool:
    mode = MODES[rows.mode]
    if mode in ("joint_position", "joint_velocity", "dex_hand_joint"):
        return joint in rows.active
    return mode in ("gripper_position", "gripper_binary", "composite_mode")


def absolute_faults(
    file: GateFile, measured: Measured, rows: PartRows, row: int, first_row: int
) -> Iterator[Fault]:
    """Every limit that one row of one part breaks, axis by axis."""
    part = file.parts[rows.part]
    block = part.modes[rows.mode]
    values = rows.values[row].tolist()
    if MODES[rows.mode] == "cartesian_pose":
        yield from pose_faults(file, rows, row)
    elif MODES[rows.mode] == "gripper_binary":
        if values[0] not in (0.0, 1.0):
            text = "exactly 0 (open) or 1 (closed)"
            nearer = 0.0 if values[0] < 0.5 else 1.0
            off = abs(values[0] - nearer)
            yield Fault(20, row, part.name, "closed", values[0], nearer, -off, text)
    elif rows.mode in JOINT_MODES:
        for index in rows.active:
            yield from _joint_faults(file, measured, rows, (row, first_row), index)
    elif "linear_limit" in block:
        for axis, three in (("linear", values[:3]), ("angular", values[3:])):
            size, limit = norm(three), block[f"{axis}_limit"]
            if not size <= limit:
                yield above(20, row, (part.name, axis), size, limit, block["source"])
    else:
        yield from _range_faults(part.name, MODES[rows.mode], block, row, values[0])


def _range_faults(part: str, mode: str, block: Block, row: int, value: float) -> Iterator[Fault]:
    """ "gripper range, composite in [-1, 1]"."""
    axis = "composite" if mode == "composite_mode" else "opening"
    lower, upper = block.get("lower", -1.0), block.get("upper", 1.0)
    if value < lower:
        yield below(20, row, (part, axis), value, lower, block["source"])
    if value > upper:
        yield above(20, row, (part, axis), value, upper, block["source"])


def _joint_faults(
    file: GateFile, measured: Measured, rows: PartRows, at: tuple[int, int], index: int
) -> Iterator[Fault]:
    row, first_row = at
    part, joint = file.parts[rows.part], file.joints[index]
    value = float(rows.values[row][index])
    where = (part.name, joint.name)
    position = float(measured.positions[index])
    if MODES[rows.mode] == "joint_velocity":
        limit = min(joint.velocity_limit, part.modes[rows.mode].get("velocity_limit", math.inf))
        yield from _symmetric(where, row, value, limit, joint.source)
        if joint.is_outside(position):
            yield from _velocity_back(where, row, value, position > joint.upper)
    elif joint.is_outside(position):
        before = position if row == first_row else float(rows.values[row - 1][index])
        yield from _position_back(where, row, value, before, joint)
    else:
        if value < joint.lower:
            yield below(20, row, where, value, joint.lower, joint.source)
        if value > joint.upper:
            yield above(20, row, where, value, joint.upper, joint.source)


def _symmetric(
    where: tuple[str, str], row: int, value: float, limit: float, source: str
) -> Iterator[Fault]:
    if value > limit:
        yield above(20, row, where, value, limit, source)
    if value < -limit:
        yield below(20, row, where, value, -limit, source)


def _velocity_back(
    where: tuple[str, str], row: int, value: float, is_above: bool
) -> Iterator[Fault]:
    """ "only rows pass that reduce the violation": standing still does not."""
    if is_above and not value < 0.0:
        yield above(11, row, where, value, 0.0, TOWARDS)
    if not is_above and not value > 0.0:
        yield below(11, row, where, value, 0.0, TOWARDS)


def _position_back(
    where: tuple[str, str], row: int, value: float, before: float, joint: Joint
) -> Iterator[Fault]:
    """Nearer to the bounds than the measurement, then than the row before; inside, anywhere."""
    now, then = joint.violation(value), joint.violation(before)
    if now > 0.0 and not now < then:
        yield above(11, row, where, now, then, TOWARDS)
