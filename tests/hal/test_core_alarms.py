"""What makes the HAL hold by itself: a pause of its own, two gates, a stop badly said."""

from __future__ import annotations

import pytest

from fairlead.messages import Acted, Hold, SafeChunk
from tests.hal.gate_messages import EPOCH, MS, SESSION, chunk, executed, grant, lease, stop
from tests.hal.realtime_hal import RealtimeHal

STOPPED = Acted(hold=Hold.STOPPED, verdict_id=0, row=0)


@pytest.fixture
def hal() -> RealtimeHal:
    return RealtimeHal()


@pytest.mark.parametrize(("pause_ms", "hold"), [(125, Hold.NONE), (126, Hold.LEASE_STALE)])
def test_the_tick_after_a_pause_holds_though_a_lease_sent_before_it_looks_fresh(
    hal: RealtimeHal, pause_ms: int, hold: Hold
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    assert hal.step(at_ms=50)[0] == executed(10, 0)
    hal.grant(at_ms=50 + pause_ms)  # read from the socket only now
    assert hal.step(at_ms=50 + pause_ms)[0].hold == hold


def test_rows_released_before_a_pause_never_run_after_it(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.core.on_safe_chunk(chunk(11, first_tick=3, after=executed(10, 1)))
    hal.grant()
    hal.step(at_ms=50)
    for at_ms in (5000, 5050, 5100):
        hal.grant(at_ms=at_ms)
        assert hal.step(at_ms=at_ms)[0].hold


def test_a_second_live_gate_holds_every_part_and_demands_one_stop(hal: RealtimeHal) -> None:
    hal.core.on_lease(lease(1, 0, epoch=EPOCH), 0)
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9, epoch=EPOCH + 1))
    hal.core.on_lease(lease(1, 0, [grant(1000)], epoch=EPOCH + 1), 0)
    assert hal.step(at_ms=50)[0] == executed(10, 0)
    assert hal.core.on_lease(lease(2, 9), 251 * MS) == "lease of a second live gate"
    hal.core.on_lease(lease(2, 1, [grant(1000)], epoch=EPOCH + 1), 251 * MS)
    assert hal.step(at_ms=100) == (STOPPED, STOPPED)
    details = (
        f"lease 2 of epoch {EPOCH:016x}, session {SESSION:016x}, is not of the gate that sent "
        f"lease 1 of epoch {EPOCH + 1:016x}"
    )
    assert hal.core.demanded_stops == (("two gates", details),)
    hal.core.on_stop_raised("two gates", stop(5))
    hal.core.on_lease(lease(3, 9), 300 * MS)
    assert len(hal.core.demanded_stops) == 0
    assert [held.stop_id for held in hal.core.held_stops] == [5]


@pytest.mark.parametrize(
    ("forged", "what"),
    [
        (
            chunk(12, 9, session=SESSION + 1),
            f"verdict 12 of epoch {EPOCH:016x}, session 0000000000001b5a",
        ),
        (chunk(10, 4), f"verdict 10 of epoch {EPOCH:016x}, session 0000000000001b59"),
    ],
)
def test_rows_that_the_gate_cannot_have_sent_hold_every_part_and_are_named(
    hal: RealtimeHal, forged: SafeChunk, what: str
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))  # the same, once more
    assert hal.step()[0] == executed(10, 0)
    assert hal.core.on_safe_chunk(forged) == "chunk of a second live gate"
    hal.grant()
    assert hal.step() == (STOPPED, STOPPED)
    details = f"{what}, is not of the gate that sent lease 1 of epoch {EPOCH:016x}"
    assert hal.core.demanded_stops == (("two gates", details),)


def test_bytes_on_the_stop_key_that_are_no_stop_hold_every_part(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    hal.core.on_unreadable_stop("3 bytes")
    assert hal.step() == (STOPPED, STOPPED)
