"""Reads the HAL's own record of what it did, while it is being written."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from fairlead.messages import Hold

CONTROL_TICKS = 10
TICK_MS = 50.0
LEASE_MS = 75.0


@dataclass(frozen=True)
class MotionLine:
    """One tick: when it was decided (CLOCK_MONOTONIC) and what each part did."""

    tick: int
    session: int
    stamp_ns: int
    holds: tuple[int, ...]
    rows: tuple[tuple[int, int], ...]
    lease_ns: int  # when the newest lease had come, on the same clock; 0: none had

    @property
    def moves(self) -> bool:
        """Whether any part executed a released row."""
        return any(hold == Hold.NONE for hold in self.holds)

    @property
    def verdicts(self) -> set[int]:
        """Verdicts whose rows acted in this tick."""
        return {row[0] for hold, row in zip(self.holds, self.rows, strict=True) if hold == 0}


class MotionLog:
    """``motion.jsonl`` from its beginning; `read` takes in what has been added."""

    def __init__(self, state_dir: Path) -> None:
        self._path = state_dir / "motion.jsonl"
        self._offset = 0
        self.lines: list[MotionLine] = []

    def read(self) -> list[MotionLine]:
        """Every complete line so far."""
        with self._path.open("rb") as file:
            file.seek(self._offset)
            added = file.read()
        complete = added[: added.rfind(b"\n") + 1]
        self._offset += len(complete)
        self.lines.extend(_parse(line) for line in complete.splitlines())
        return self.lines

    def since(self, stamp_ns: int) -> list[MotionLine]:
        """Lines of ticks decided then or later (CLOCK_MONOTONIC)."""
        return [line for line in self.read() if line.stamp_ns >= stamp_ns]


def hold_delay_ms(lines: Iterable[MotionLine], injected_ns: int) -> float:
    """Injection to the tick from which on nothing moved; asserts that it stays so."""
    last_move_ns, first_hold_ns = injected_ns, None
    for line in lines:
        if line.moves:
            last_move_ns, first_hold_ns = line.stamp_ns, None
        elif first_hold_ns is None:
            first_hold_ns = line.stamp_ns
    assert first_hold_ns is not None and first_hold_ns >= last_move_ns
    return (first_hold_ns - injected_ns) / 1e6


def assert_held_within(
    bound_ms: float, lines: list[MotionLine], injected_ns: int, late_ms: float, what: str
) -> None:
    """Nothing moved later than a bound after an injection, nor on a lease that had lapsed.

    The second is the HAL's, by its own clock, however late the machine is. From the first is taken
    what the machine was late itself: it woke a process that only sleeps so late, or the HAL before.

    Args:
        lines: before the injection, as many as make a control, and all after it.
        late_ms: how late that process was woken between the injection and the hold, at most.
    """
    before = [line for line in lines if line.stamp_ns < injected_ns][-CONTROL_TICKS:]
    after = [line for line in lines if line.stamp_ns >= injected_ns]
    delay_ms, tick_ms = hold_delay_ms(after, injected_ns), longest_tick_ms(before)
    leases_ms = [(line.stamp_ns - line.lease_ns) / 1e6 for line in after if line.moves]
    lease_ms = max(leases_ms, default=0.0)
    print(
        f"{what}: held after {delay_ms:.0f} ms (bound {bound_ms:g} ms), moved on leases of "
        f"{lease_ms:.0f} ms; control: longest undisturbed tick {tick_ms:.0f} ms, "
        f"a sleeper woken {late_ms:.0f} ms late"
    )
    assert lease_ms <= LEASE_MS
    assert delay_ms <= bound_ms + max(late_ms, tick_ms - TICK_MS)


def longest_tick_ms(lines: list[MotionLine]) -> float:
    """The longest time between two decisions; 0 if there are not two."""
    stamps = [line.stamp_ns for line in lines]
    return max((later - one for one, later in pairwise(stamps)), default=0) / 1e6


def _parse(line: bytes) -> MotionLine:
    entry = json.loads(line)
    return MotionLine(
        tick=entry["tick"],
        session=entry["session"],
        stamp_ns=entry["stamp_ns"],
        holds=tuple(part[0] for part in entry["acted"]),
        rows=tuple((part[1], part[2]) for part in entry["acted"]),
        lease_ns=entry["lease_ns"],
    )
