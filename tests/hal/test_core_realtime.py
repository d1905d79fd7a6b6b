"""The execution guard in realtime pacing: what runs, what holds, and why."""

from __future__ import annotations

import pytest

from fairlead.messages import Acted, Hold
from tests.hal.gate_messages import (
    CLAIM,
    MS,
    chunk,
    executed,
    grant,
    lease,
    stop,
)
from tests.hal.realtime_hal import RealtimeHal

HOLD_STARTING = Acted(hold=Hold.STARTING, verdict_id=0, row=0)


@pytest.fixture
def hal() -> RealtimeHal:
    return RealtimeHal()


def test_before_the_first_message_every_part_holds_and_says_starting(hal: RealtimeHal) -> None:
    assert hal.step() == (HOLD_STARTING, HOLD_STARTING)


def test_granted_rows_run_in_order_then_the_part_holds_for_want_of_rows(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=2, horizon=2))
    hal.grant()
    assert hal.step()[0].hold == Hold.NO_ROW
    hal.grant()
    assert hal.step()[0] == executed(10, 0)
    hal.grant()
    assert hal.step()[0] == executed(10, 1)
    hal.grant()
    assert hal.step()[0].hold == Hold.NO_ROW


def test_a_part_that_no_chunk_addresses_holds_beside_one_that_moves(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1))
    hal.grant()
    assert hal.step() == (executed(10, 0), Acted(hold=Hold.NO_CLAIM, verdict_id=0, row=0))


def test_rows_without_a_lease_never_run(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1))
    assert hal.holds()[0] == Hold.STARTING


def test_rows_of_a_claim_that_the_lease_does_not_grant_never_run(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, claim=CLAIM + 1))
    hal.grant()
    assert hal.holds()[0] == Hold.NOT_GRANTED


@pytest.mark.parametrize(("until_tick", "runs"), [(2, True), (1, False)])
def test_a_grant_reaches_up_to_and_including_its_until_tick(
    hal: RealtimeHal, until_tick: int, runs: bool
) -> None:
    hal.grant()
    hal.step()
    hal.core.on_safe_chunk(chunk(10, first_tick=2))
    hal.grant(until_tick=until_tick)
    assert hal.holds()[0] == (Hold.NONE if runs else Hold.NOT_GRANTED)


@pytest.mark.parametrize(("age_ms", "hold"), [(75, Hold.NONE), (76, Hold.LEASE_STALE)])
def test_a_lease_lives_75_ms_by_the_hals_own_clock(
    hal: RealtimeHal, age_ms: int, hold: Hold
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1))
    hal.grant(at_ms=1000)
    assert hal.step(at_ms=1000 + age_ms)[0].hold == hold


def test_a_repeated_lease_does_not_live_longer(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1))
    message = lease(1, 0, [grant(1000)])
    assert hal.core.on_lease(message, 0) == ""
    assert hal.core.on_lease(message, 70 * MS) == "lease not newer"
    assert hal.step(at_ms=80)[0].hold == Hold.LEASE_STALE


def test_after_two_lost_leases_held_rows_never_resume_without_a_new_judgement(
    hal: RealtimeHal,
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=20))
    hal.grant(at_ms=50)
    assert hal.step(at_ms=50)[0] == executed(10, 0)
    assert hal.step(at_ms=100)[0] == executed(10, 1)
    assert hal.step(at_ms=150)[0].hold == Hold.LEASE_STALE
    hal.grant(at_ms=199)
    assert hal.step(at_ms=200)[0].hold == Hold.NO_ROW
    assert hal.step(at_ms=250)[0].hold == Hold.NO_ROW


def test_a_chunk_judged_after_the_hold_moves_the_part_again(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=1))
    for _ in range(2):
        hal.grant()
        hal.step()
    hal.core.on_safe_chunk(chunk(11, first_tick=3))
    hal.grant()
    assert hal.step()[0] == executed(11, 0)


def test_a_held_stop_beats_a_granted_row_and_discards_the_rows(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    assert hal.step()[0] == executed(10, 0)
    assert hal.core.on_stop(stop(5)) == ""
    hal.grant()
    assert hal.holds() == (Hold.STOPPED, Hold.STOPPED)


def test_while_an_episode_is_reset_every_part_holds(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    hal.core.set_resetting(True)
    assert hal.holds() == (Hold.RESETTING, Hold.RESETTING)
    hal.core.set_resetting(False)
    hal.grant()
    assert hal.holds()[0] == Hold.NO_ROW


def test_a_tick_that_the_backend_refused_counts_as_held(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    hal.step()
    hal.core.void(Hold.STOPPED)
    assert hal.core.acted[0].hold == Hold.STOPPED
    hal.grant()
    assert hal.holds()[0] == Hold.NO_ROW


def test_a_tick_skipped_in_number_counts_as_held(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.core.on_safe_chunk(chunk(11, first_tick=3, after=executed(10, 0)))
    hal.grant()
    hal.step()
    hal.tick += 1
    hal.grant()
    assert hal.step()[0].hold


def test_no_tick_is_decided_twice(hal: RealtimeHal) -> None:
    hal.step()
    with pytest.raises(ValueError, match=r"tick 1 was decided before \(newest 1\)"):
        hal.core.decide(1, 0, is_still=True)
