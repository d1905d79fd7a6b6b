"""Reference against core: what a case should have got, what it got, and the smallest such case."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from bench.equipment.case import ActedRow, Before, Case, Chunk, Measured, PartRows
from bench.equipment.core_gate import Answer
from fairlead.messages import Outcome
from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.verdict_text import is_rule
from tests.differential.claims import tightened
from tests.differential.fault import Fault
from tests.differential.gate_file import MODES, GateFile
from tests.differential.reference import NOT_ARMED, Ruling, has_stopped, judge, open_tick

NOTHING = Fault(0, -1, "", "")
UNREACHABLE, BRAKING = 30, 24
ULPS = 4
"""Of the values: norms may be summed in another order."""
ON_A_BOUND = 1e-9
"""rad or m."""
KINEMATICS = 1e-12
"""m, rad and per s: two ways to compute where a tool is."""


@dataclass(frozen=True)
class Difference:
    """One field of one answer."""

    which: str
    field: str
    expected: object
    got: object


def rulings(file: GateFile, case: Case) -> list[Ruling]:
    """What the reference says of the earlier chunk, if there is one, and of the chunk."""
    file = tightened(file, case.overrides)
    first = case.first or case.measured
    before: Before = {}
    found = []
    if case.earlier is not None:
        tick = open_tick(case.pacing, first.tick)
        found.append(judge(file, case.horizon_max, tick, first, {}, case.earlier))
        is_measured = case.pacing == "lockstep"
        before = {} if case.held else acted_rows(case.earlier, found[0], is_measured)
    tick = open_tick(case.pacing, case.measured.tick)
    measured = case.measured
    if case.earlier is not None:
        measured = replace(measured, came_from=first.positions)
    ruling = judge(file, case.horizon_max, tick, measured, before, case.chunk)
    if (
        case.earlier is not None
        and not case.held
        and has_stopped(file, case.measured, case.earlier, found[0])
    ):
        ruling = NOT_ARMED
    return [*found, ruling]


def acted_rows(chunk: Chunk, ruling: Ruling, is_measured: bool) -> Before:
    """What the parts did when the HAL executed the first released row."""
    if ruling.row_count == 0:
        return {}
    return {
        rows.part: ActedRow(
            rows.mode, rows.frame, rows.active, rows.values[ruling.first_row], is_measured
        )
        for rows in chunk.parts
    }


def differences(
    file: GateFile, case: Case, expected: list[Ruling], answers: list[Answer]
) -> list[Difference]:
    """Every field in which gate and reference differ."""
    chunks = [case.chunk] if case.earlier is None else [case.earlier, case.chunk]
    if any(_is_about_a_configuration(*pair) for pair in zip(chunks, answers, strict=True)):
        return []  # of a pose; the reference does not look for configurations
    states = (
        [case.measured] if case.earlier is None else [case.first or case.measured, case.measured]
    )
    if any(_brakes_at_a_bound(file, *pair) for pair in zip(states, answers, strict=True)):
        return []
    return [
        difference
        for chunk, ruling, answer in zip(chunks, expected, answers, strict=True)
        for difference in _of_one(chunk, ruling, answer)
    ]


def _is_about_a_configuration(chunk: Chunk, answer: Answer) -> bool:
    has_pose = any(rows.mode == MODES.index("cartesian_pose") for rows in chunk.parts)
    return answer.verdict.code == UNREACHABLE or (has_pose and answer.verdict.code == BRAKING)


def _brakes_at_a_bound(file: GateFile, measured: Measured, answer: Answer) -> bool:
    """G024 of a joint that is measured on a bound or beyond it: the least motion is too much there.
    The reference does not know G024: `test_paths` has it."""
    if answer.verdict.code != BRAKING:
        return False
    joints = {joint.name: index for index, joint in enumerate(file.joints)}
    index = joints[answer.verdict.axis]
    joint, position = file.joints[index], float(measured.positions[index])
    return not joint.lower + ON_A_BOUND < position < joint.upper - ON_A_BOUND


def _of_one(chunk: Chunk, ruling: Ruling, answer: Answer) -> Iterator[Difference]:
    which = f"seq {answer.verdict.seq}"
    for field, expected, got in _pairs(chunk, ruling, answer):
        if not _same(expected, got, _tolerance(answer, field)):
            yield Difference(which, field, expected, got)


def _pairs(chunk: Chunk, ruling: Ruling, answer: Answer) -> Iterator[tuple[str, object, object]]:
    verdict, fault = answer.verdict, ruling.fault or NOTHING
    yield "outcome", ruling.outcome.name, Outcome(verdict.outcome).name
    yield "code", fault.code, verdict.code
    yield "row", fault.row, verdict.row
    yield "part", fault.part, verdict.part
    yield "axis", fault.axis, verdict.axis
    yield "value", fault.value, verdict.value
    yield "limit", fault.limit, verdict.limit
    yield "margin", fault.margin, verdict.margin
    yield "limit_source", fault.source, verdict.limit_source
    if not is_rule(verdict):
        units = CHECKS[verdict.code].units
        yield "unit", verdict.unit if verdict.unit in units else units, verdict.unit
    yield "stopped", ruling.stops, answer.stopped
    is_any = ruling.row_count > 0
    first = chunk.start_tick + ruling.first_row if is_any else 0
    yield "released_first", first, verdict.released_first
    last = first + ruling.row_count - 1 if is_any else 0
    yield "released_last", last, verdict.released_last
    if is_any and answer.safe is not None:
        yield "released rows", _released(chunk, ruling), _sent(answer)


def _released(chunk: Chunk, ruling: Ruling) -> list[tuple[object, ...]]:
    kept = slice(ruling.first_row, ruling.first_row + ruling.row_count)
    return [
        (rows.part, rows.mode, rows.frame, rows.active, rows.values[kept].tobytes())
        for rows in chunk.parts
    ]


def _sent(answer: Answer) -> list[tuple[object, ...]]:
    assert answer.safe is not None
    return [(p.part, p.mode, p.frame_id, p.active, p.values) for p in answer.safe.parts]


def _tolerance(answer: Answer, field: str) -> float:
    """How far numbers may lie apart: a few units in the last place of those they come from."""
    verdict = answer.verdict
    size = max(abs(verdict.value), abs(verdict.limit), 1e-3)
    if field not in ("value", "margin") or not math.isfinite(size):
        return 0.0
    is_of_a_tool = verdict.axis in ("linear", "angular")
    return max(ULPS * float(np.spacing(size)), KINEMATICS if is_of_a_tool else 0.0)


def _same(expected: object, got: object, tolerance: float) -> bool:
    if isinstance(expected, float) and isinstance(got, float):
        if math.isnan(expected) and math.isnan(got):
            return True
        return expected == got or abs(expected - got) <= tolerance
    return expected == got


def smaller(case: Case) -> Iterator[Case]:
    """The case with one thing left out."""
    if case.earlier is not None:
        yield replace(case, earlier=None, first=None, held=False)
        yield from (replace(case, earlier=chunk) for chunk in _smaller_chunks(case.earlier))
    for at in range(len(case.overrides)):
        yield replace(case, overrides=case.overrides[:at] + case.overrides[at + 1 :])
    yield from (replace(case, chunk=chunk) for chunk in _smaller_chunks(case.chunk))


def _smaller_chunks(chunk: Chunk) -> Iterator[Chunk]:
    for at in range(len(chunk.parts)):
        if len(chunk.parts) > 1:
            yield replace(chunk, parts=chunk.parts[:at] + chunk.parts[at + 1 :])
    if chunk.horizon > 1 and all(len(rows.values) == chunk.horizon for rows in chunk.parts):
        yield _without_row(chunk, slice(0, -1), 0)
        yield _without_row(chunk, slice(1, None), 1)


def _without_row(chunk: Chunk, kept: slice, late: int) -> Chunk:
    parts = tuple(replace(rows, values=rows.values[kept]) for rows in chunk.parts)
    return Chunk(chunk.start_tick + late, chunk.horizon - 1, parts)


def smallest(case: Case, differs: Callable[[Case], bool]) -> Case:
    """A case that still differs and from which nothing can be left out."""
    while True:
        for candidate in smaller(case):
            if differs(candidate):
                case = candidate
                break
        else:
            return case


def readable(case: Case, found: list[Difference]) -> str:
    """A disagreement as text, with everything needed to make it again."""
    lines = [f"{case.robot}, {case.pacing}, {case.about or 'ordinary rows'}"]
    for difference in found:
        lines.append(
            f"  {difference.which} {difference.field}: reference {difference.expected!r}, "
            f"gate {difference.got!r}"
        )
    for name, state in (("first", case.first), ("measured", case.measured)):
        if state is not None:
            lines.append(f"  {name}: tick {state.tick}, positions {state.positions.tolist()}")
            lines.append(f"    velocities {state.velocities.tolist()}")
    lines += [f"  override: {override}" for override in case.overrides]
    lines.append(f"  horizon_max {case.horizon_max}, held {case.held}")
    for name, chunk in (("earlier", case.earlier), ("chunk", case.chunk)):
        if chunk is not None:
            lines.append(f"  {name}: start {chunk.start_tick}, horizon {chunk.horizon}")
            lines += [f"    {_described(rows)}" for rows in chunk.parts]
    return "\n".join(lines)


def _described(rows: PartRows) -> str:
    return f"part {rows.part} mode {rows.mode} {rows.frame!r} {rows.active} {rows.values.tolist()}"
