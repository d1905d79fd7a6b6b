"""Realtime ticks slip when work takes too long; they never come in bursts."""

from __future__ import annotations

from fairlead.hal.loop_state import PeriodClock
from tests.hal.gate_messages import MS


def test_ticks_come_a_period_apart_and_waking_late_does_not_add_up() -> None:
    clock = PeriodClock(50 * MS, now_ns=0)
    assert clock.start_tick(10 * MS) == 40 * MS
    assert clock.start_tick(51 * MS) == 49 * MS
    assert clock.overruns == 0


def test_an_overrun_moves_all_later_ticks_and_is_counted() -> None:
    clock = PeriodClock(50 * MS, now_ns=0)
    assert clock.start_tick(170 * MS) == 0
    assert clock.overruns == 1
    assert clock.start_tick(180 * MS) == 40 * MS
    assert clock.overruns == 1


def test_a_restart_is_no_overrun() -> None:
    clock = PeriodClock(50 * MS, now_ns=0)
    clock.restart(5000 * MS)
    assert clock.start_tick(5010 * MS) == 40 * MS
    assert clock.overruns == 0
