"""What must hold between two chunks, whatever the right verdict on either is.

Only the core is asked. A failure prints the case and the seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows
from fairlead.messages import Outcome, Verdict
from tests.differential.chunks import CaseMaker
from tests.differential.claims import drawn_override, tightenable, tightened
from tests.differential.comparison import readable
from tests.differential.gate_file import JOINT_MODES, GateFile
from tests.differential.gates import Pair

pytestmark = pytest.mark.processes

SEED = 4711
COUNT = 60
LONG_COUNT = 4_000
SHAPE_CODES = (4, 6, 7, 8, 9)

counts = pytest.mark.parametrize(
    "count", [COUNT, pytest.param(LONG_COUNT, marks=[pytest.mark.soak, pytest.mark.timeout(3600)])]
)


def cases(pair: Pair, count: int) -> Iterator[Case]:
    """Drawn cases in which nothing acted before."""
    maker = CaseMaker(pair.robot, pair.file, SEED)
    for _ in range(count):
        case = maker.draw()
        if case.earlier is None:
            yield case


def verdict_on(pair: Pair, case: Case) -> Verdict:
    return pair.answers(case)[-1].verdict


def released(verdict: Verdict) -> int:
    """Rows let through."""
    if verdict.outcome == Outcome.REFUSED:
        return 0
    return verdict.released_last - verdict.released_first + 1


def told(case: Case) -> str:
    return f"seed {SEED}\n{readable(case, [])}"


def with_rows(case: Case, change: Callable[[PartRows], PartRows], **fields: int) -> Case:
    parts = tuple(change(rows) for rows in case.chunk.parts)
    return replace(case, chunk=replace(case.chunk, parts=parts, **fields))


def is_regular(case: Case) -> bool:
    """As many rows as it says, in every part."""
    return all(len(rows.values) == case.chunk.horizon for rows in case.chunk.parts)


def tighter(file: GateFile, case: Case, rng: np.random.Generator) -> Case:
    """The same under a claim with one more limit of each commanded mode made tighter."""
    overrides = list(case.overrides)
    for rows in case.chunk.parts:
        if rows.part >= len(file.parts) or rows.mode not in file.parts[rows.part].modes:
            continue
        now = tightened(file, overrides)
        if tightenable(now, rows.part, rows.mode):
            overrides.append(drawn_override(now, rows.part, rows.mode, rng))
    is_shorter = rng.random() < 0.2
    horizon_max = int(rng.integers(1, case.horizon_max + 1)) if is_shorter else case.horizon_max
    return replace(case, overrides=tuple(overrides), horizon_max=horizon_max)


@counts
def test_tighter_limits_never_release_more(pair: Pair, count: int) -> None:
    rng = np.random.default_rng(SEED)
    fewer = 0
    for case in cases(pair, count):
        tight = tighter(pair.file, case, rng)
        loose_rows, tight_rows = released(verdict_on(pair, case)), released(verdict_on(pair, tight))
        assert tight_rows <= loose_rows, told(tight)
        fewer += tight_rows < loose_rows
    assert fewer >= 1, "the tighter limits were never the ones that counted"


@counts
def test_a_prefix_of_what_was_released_is_released(pair: Pair, count: int) -> None:
    longest = 0
    for case in cases(pair, count):
        verdict = verdict_on(pair, case)
        rows = released(verdict)
        if not rows or not is_regular(case):
            continue
        first = verdict.released_first - case.chunk.start_tick
        for kept in range(1, rows + 1):
            end = first + kept
            short = with_rows(case, lambda p, e=end: replace(p, values=p.values[:e]), horizon=end)  # type: ignore[misc]
            again = verdict_on(pair, short)
            assert (again.outcome, released(again)) == (Outcome.RELEASED, kept), told(short)
        longest = max(longest, rows)
    assert longest >= 2


@counts
def test_numbers_outside_the_mask_release_nothing(pair: Pair, count: int) -> None:
    rng = np.random.default_rng(SEED)
    seen = 0
    for case in cases(pair, count):
        columns = list(range(len(pair.file.joints)))

        def change(rows: PartRows, columns: list[int] = columns) -> PartRows:
            idle = [n for n in columns if n not in rows.active]
            if rows.mode not in JOINT_MODES or not idle or rows.values.shape[1] != len(columns):
                return rows
            values = rows.values.copy()
            row = rng.integers(len(values)) if len(values) else slice(None)
            values[row, rng.choice(idle)] = rng.choice([1e-300, -0.5, 3.0])
            return replace(rows, values=values)

        padded = with_rows(case, change)
        if any(a is not b for a, b in zip(case.chunk.parts, padded.chunk.parts, strict=True)):
            assert released(verdict_on(pair, padded)) == 0, told(padded)
            seen += 1
    assert seen >= 1 or not any(m in p.modes for p in pair.file.parts for m in JOINT_MODES)


@counts
def test_past_rows_in_front_change_nothing(pair: Pair, count: int) -> None:
    """Whatever they say, as long as it is a number: they are dropped by their index."""
    rng = np.random.default_rng(SEED)
    for case in cases(pair, count):
        start, most = case.chunk.start_tick, min(case.horizon_max, 64)
        late = case.measured.tick + int(case.pacing == "realtime")
        if start != late or not is_regular(case) or case.chunk.horizon + 1 > most or start < 2:
            continue

        def change(rows: PartRows) -> PartRows:
            past = np.where(rows.values[:1] == 0.0, 0.0, rng.uniform(-1e5, 1e5))
            return replace(rows, values=np.vstack([past, rows.values]))

        one = verdict_on(pair, case)
        if one.code in SHAPE_CODES:
            continue
        longer = with_rows(case, change, horizon=case.chunk.horizon + 1, start_tick=start - 1)
        two = verdict_on(pair, longer)
        assert _without_rows(one) == _without_rows(two), told(longer)
        assert two.row == (one.row + 1 if one.row >= 0 else -1), told(longer)


def _without_rows(verdict: Verdict) -> tuple[object, ...]:
    ticks = (verdict.released_first, verdict.released_last)
    return (verdict.outcome, verdict.code, verdict.part, verdict.axis, *ticks)


@counts
def test_the_order_of_the_parts_does_not_count(pair: Pair, count: int) -> None:
    rng = np.random.default_rng(SEED)
    seen = 0
    for case in cases(pair, count):
        parts = case.chunk.parts
        if len(parts) < 2:
            continue
        order = rng.permutation(len(parts)).tolist()
        shuffled = replace(case.chunk, parts=tuple(parts[n] for n in order))
        one = verdict_on(pair, case)
        two = verdict_on(pair, replace(case, chunk=shuffled))
        assert (one.outcome, one.released_first, one.released_last) == (
            two.outcome,
            two.released_first,
            two.released_last,
        ), told(case)
        seen += 1
    assert seen >= count // 10


@counts
def test_the_same_at_another_time_is_judged_the_same(pair: Pair, count: int) -> None:
    rng = np.random.default_rng(SEED)
    for case in cases(pair, count):
        if not 90 <= case.chunk.start_tick <= 110:
            continue
        later = int(rng.choice([1, 1000, 2**32, 2**53]))
        measured = replace(case.measured, tick=case.measured.tick + later)
        chunk = Chunk(case.chunk.start_tick + later, case.chunk.horizon, case.chunk.parts)
        one = verdict_on(pair, case)
        two = verdict_on(pair, replace(case, measured=measured, chunk=chunk))
        assert _measure(one) == _measure(two), told(case)


def _measure(verdict: Verdict) -> tuple[object, ...]:
    """What was found where; not the numbers of checks that count ticks, or of no number."""
    place = (verdict.outcome, verdict.code, verdict.row, verdict.part, verdict.axis)
    return place if verdict.code in (6, 8, 12) else (*place, verdict.value, verdict.limit)
