"""Which chunk's row the execution guard executes in realtime pacing."""

from __future__ import annotations

import pytest

from fairlead.errors import MessageError
from fairlead.messages import Acted, Hold
from tests.hal.gate_messages import (
    CLAIM,
    EPOCH,
    MS,
    SESSION,
    chunk,
    executed,
    grant,
    lease,
)
from tests.hal.realtime_hal import RealtimeHal


@pytest.fixture
def hal() -> RealtimeHal:
    return RealtimeHal()


def test_a_chunk_that_continues_the_row_that_ran_takes_over_at_its_first_tick(
    hal: RealtimeHal,
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=8))
    hal.core.on_safe_chunk(chunk(11, first_tick=3, after=executed(10, 1)))
    ran = []
    for _ in range(4):
        hal.grant()
        ran.append(hal.step()[0])
    assert ran == [executed(10, 0), executed(10, 1), executed(11, 0), executed(11, 1)]


@pytest.mark.parametrize("after", [executed(10, 0), executed(9, 1)])
def test_a_chunk_that_continues_something_else_is_dropped_and_the_old_rows_go_on(
    hal: RealtimeHal, after: Acted
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=8))
    hal.core.on_safe_chunk(chunk(11, first_tick=3, after=after))
    ran = []
    for _ in range(4):
        hal.grant()
        ran.append(hal.step()[0])
    assert ran == [executed(10, row) for row in range(4)]


def test_a_chunk_that_expects_a_hold_is_dropped_where_a_row_ran(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=1))
    hal.core.on_safe_chunk(chunk(11, first_tick=2))
    hal.grant()
    hal.step()
    hal.grant()
    assert hal.holds()[0] == Hold.SUPERSEDED


def test_a_chunk_that_expects_a_row_is_dropped_where_the_part_held(hal: RealtimeHal) -> None:
    hal.grant()
    hal.step()
    hal.core.on_safe_chunk(chunk(11, first_tick=2, after=executed(10, 3)))
    hal.grant()
    assert hal.holds()[0] == Hold.SUPERSEDED


def test_two_holds_match_whatever_their_codes(hal: RealtimeHal) -> None:
    hal.step()
    refused = Acted(hold=Hold.REFUSED, verdict_id=0, row=0)
    hal.core.on_safe_chunk(chunk(11, first_tick=2, after=refused))
    hal.grant()
    assert hal.step()[0] == executed(11, 0)


@pytest.mark.parametrize("order", [(20, 21), (21, 20)])
def test_of_two_chunks_the_higher_verdict_wins_in_any_order_of_arrival(
    hal: RealtimeHal, order: tuple[int, int]
) -> None:
    for verdict_id in order:
        hal.core.on_safe_chunk(chunk(verdict_id, first_tick=1))
    hal.grant()
    assert hal.step()[0] == executed(21, 0)


def test_an_older_verdict_never_replaces_a_newer_one(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(20, first_tick=2, after=executed(21, 0)))
    hal.core.on_safe_chunk(chunk(21, first_tick=1))
    for row in range(2):
        hal.grant()
        assert hal.step()[0] == executed(21, row)
    late = chunk(19, first_tick=3, after=executed(21, 1))
    assert hal.core.on_safe_chunk(late) == "chunk superseded"


def test_a_newer_chunk_replaces_all_rows_also_where_it_is_shorter(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=8))
    hal.core.on_safe_chunk(chunk(11, first_tick=2, horizon=1, after=executed(10, 0)))
    holds = []
    for _ in range(3):
        hal.grant()
        holds.append(hal.holds()[0])
    assert holds == [Hold.NONE, Hold.NONE, Hold.NO_ROW]


@pytest.mark.parametrize(("first_tick", "reason"), [(3, ""), (2, "passed"), (1, "passed")])
def test_a_chunk_is_taken_only_while_its_first_tick_lies_ahead(
    hal: RealtimeHal, first_tick: int, reason: str
) -> None:
    hal.step()
    hal.step()
    refused = hal.core.on_safe_chunk(chunk(10, first_tick=first_tick, horizon=9))
    assert refused == ("chunk whose first tick has passed" if reason else "")
    hal.grant()
    assert (hal.holds()[0] == Hold.NONE) is not bool(reason)


def test_a_chunk_of_another_session_is_refused(hal: RealtimeHal) -> None:
    assert hal.core.on_safe_chunk(chunk(10, 1, session=SESSION + 1)) == "chunk of another session"
    hal.grant()
    assert hal.holds()[0] == Hold.NO_CLAIM


def test_a_chunk_of_an_epoch_the_lease_does_not_name_never_runs(hal: RealtimeHal) -> None:
    assert hal.core.on_safe_chunk(chunk(10, 1, epoch=EPOCH + 1)) == ""
    hal.grant()
    assert hal.holds()[0] == Hold.NOT_GRANTED


def test_a_chunk_of_an_epoch_already_left_is_refused(hal: RealtimeHal) -> None:
    hal.core.on_lease(lease(1, 0, epoch=EPOCH), 0)
    hal.core.on_lease(lease(1, 0, epoch=EPOCH + 1), 0)
    assert hal.core.on_safe_chunk(chunk(10, 1)) == "chunk of an epoch already left"


def test_rows_of_the_old_epoch_are_gone_when_a_new_one_begins(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    hal.grant()
    assert hal.step()[0] == executed(10, 0)
    hal.core.on_lease(lease(1, 1, [grant(1000)], epoch=EPOCH + 1), 100 * MS)
    assert hal.holds()[0] == Hold.NO_CLAIM


def test_a_duplicate_chunk_changes_nothing(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=2))
    assert hal.core.on_safe_chunk(chunk(10, first_tick=2)) == "chunk already known"
    hal.step()
    hal.grant()
    assert hal.step()[0] == executed(10, 0)
    again = chunk(10, first_tick=2)
    assert hal.core.on_safe_chunk(again) == "chunk whose first tick has passed"


def test_parts_of_one_chunk_move_and_hold_together(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=1, parts=(0, 1)))
    hal.grant()
    assert hal.step() == (executed(10, 0), executed(10, 0))
    hal.grant()
    assert hal.holds() == (Hold.NO_ROW, Hold.NO_ROW)


def test_a_part_that_joins_a_moving_claim_may_have_held_before(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, parts=(0,)))
    hal.core.on_safe_chunk(chunk(11, first_tick=2, parts=(0, 1), after=executed(10, 0)))
    hal.grant()
    hal.step()
    hal.grant()
    assert hal.step() == (executed(11, 0), executed(11, 0))


def test_a_new_claim_does_not_start_while_another_one_still_moves_its_part(
    hal: RealtimeHal,
) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, horizon=1, claim=CLAIM))
    hal.core.on_safe_chunk(chunk(11, first_tick=2, claim=CLAIM + 1))
    both = [grant(9), grant(9, claim=CLAIM + 1)]
    hal.core.on_lease(lease(1, 0, both), 50 * MS)
    assert hal.step()[0] == executed(10, 0)
    assert hal.holds()[0] != Hold.NONE


def test_two_claims_that_command_one_part_in_one_tick_both_hold(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, claim=CLAIM))
    hal.core.on_safe_chunk(chunk(11, first_tick=1, claim=CLAIM + 1))
    both = [grant(9), grant(9, claim=CLAIM + 1)]
    hal.core.on_lease(lease(1, 0, both), 50 * MS)
    assert hal.holds()[0] == Hold.SUPERSEDED


def test_two_claims_with_different_parts_move_in_the_same_tick(hal: RealtimeHal) -> None:
    hal.core.on_safe_chunk(chunk(10, first_tick=1, claim=CLAIM, parts=(0,)))
    hal.core.on_safe_chunk(chunk(11, first_tick=1, claim=CLAIM + 1, parts=(1,)))
    both = [grant(9), grant(9, claim=CLAIM + 1)]
    hal.core.on_lease(lease(1, 0, both), 50 * MS)
    assert hal.step() == (executed(10, 0), executed(11, 0))


def test_a_chunk_for_a_part_the_robot_does_not_have_is_no_chunk(hal: RealtimeHal) -> None:
    with pytest.raises(MessageError, match="SafeChunk: expected part < 2, got 2"):
        hal.core.on_safe_chunk(chunk(10, first_tick=1, parts=(2,)))
    hal.grant()
    assert hal.holds()[0] == Hold.NO_CLAIM


def test_a_flood_of_chunks_and_claims_is_bounded_and_keeps_the_granted_claim(
    hal: RealtimeHal,
) -> None:
    hal.grant()
    hal.core.on_safe_chunk(chunk(10, first_tick=1))
    for number in range(200):
        hal.core.on_safe_chunk(chunk(1000 + number, first_tick=9, claim=9000 + number))
    assert hal.step()[0] == executed(10, 0)
