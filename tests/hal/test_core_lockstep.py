"""The execution guard in lockstep: the world waits for its decision, and only for that."""

from __future__ import annotations

import pytest

from fairlead.hal.core import HalCore, TickPlan, Wait
from fairlead.messages import Decision, GateState, Hold
from tests.hal.gate_messages import (
    CLAIM,
    EPOCH,
    N_DOF,
    PARTS,
    PERIOD_NS,
    SESSION,
    chunk,
    executed,
    grant,
    lease,
    stop,
)

WAITS_FOR_LEASE = Wait("lease")
PAUSED = Wait("standstill")


@pytest.fixture
def core() -> HalCore:
    return HalCore(SESSION, "lockstep", PARTS, N_DOF, PERIOD_NS)


def decide(core: HalCore, tick: int, is_still: bool = True) -> TickPlan | Wait:
    """Time never counts in lockstep: every call comes an hour after the one before."""
    return core.decide(tick, tick * 3600 * 10**9, is_still)


def ran(plan: TickPlan | Wait) -> object:
    assert isinstance(plan, TickPlan)
    return plan.acted[0]


def test_a_world_nobody_claims_steps_until_standstill_and_pauses(core: HalCore) -> None:
    assert isinstance(decide(core, 1, is_still=False), TickPlan)
    assert isinstance(decide(core, 2, is_still=False), TickPlan)
    assert decide(core, 3, is_still=True) == PAUSED


def test_a_claimed_world_does_not_step_without_a_lease_of_this_tick(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 0, [grant(0, verdict_id=10)]), 0)
    assert decide(core, 1, is_still=False) == WAITS_FOR_LEASE


def test_an_undecided_claim_keeps_the_world_waiting(core: HalCore) -> None:
    core.on_lease(lease(1, 1, [grant(1, Decision.UNDECIDED)]), 0)
    assert decide(core, 1) == WAITS_FOR_LEASE


def test_a_decided_row_runs(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    assert ran(decide(core, 1)) == executed(10, 0)


def test_a_decided_row_whose_chunk_is_still_under_way_is_waited_for(core: HalCore) -> None:
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    assert decide(core, 1) == WAITS_FOR_LEASE
    core.on_safe_chunk(chunk(9, first_tick=1))
    assert decide(core, 1) == WAITS_FOR_LEASE
    core.on_safe_chunk(chunk(10, first_tick=1))
    assert ran(decide(core, 1)) == executed(10, 0)


def test_the_next_rows_of_a_chunk_need_a_decision_for_each_tick(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    assert ran(decide(core, 1)) == executed(10, 0)
    assert decide(core, 2) == WAITS_FOR_LEASE
    core.on_lease(lease(2, 2, [grant(2, verdict_id=10)]), 0)
    assert ran(decide(core, 2)) == executed(10, 1)


def test_a_row_beyond_the_chunk_is_waited_for_not_invented(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1, horizon=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_lease(lease(2, 2, [grant(2, verdict_id=10)]), 0)
    assert decide(core, 2) == WAITS_FOR_LEASE


def test_a_chunk_that_does_not_continue_what_ran_is_waited_out(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_safe_chunk(chunk(11, first_tick=2, after=executed(10, 3)))
    core.on_lease(lease(2, 2, [grant(2, verdict_id=11)]), 0)
    assert decide(core, 2) == WAITS_FOR_LEASE
    core.on_safe_chunk(chunk(12, first_tick=2, after=executed(10, 0)))
    core.on_lease(lease(3, 2, [grant(2, verdict_id=12)]), 0)
    assert ran(decide(core, 2)) == executed(12, 0)


def test_the_lease_names_the_verdict_that_runs_whatever_else_is_there(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_safe_chunk(chunk(11, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    assert ran(decide(core, 1)) == executed(10, 0)


def test_a_refused_chunk_is_a_held_tick_moving_or_still(core: HalCore) -> None:
    for tick, is_still in ((1, True), (2, False)):
        core.on_lease(lease(tick, tick, [grant(tick, Decision.HOLD)]), 0)
        plan = decide(core, tick, is_still)
        assert isinstance(plan, TickPlan) and not plan.commands


def test_a_held_tick_discards_the_rows_that_were_left(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_lease(lease(2, 2, [grant(2, Decision.HOLD)]), 0)
    plan = decide(core, 2)
    assert isinstance(plan, TickPlan) and plan.acted[0].hold == Hold.REFUSED
    core.on_lease(lease(3, 3, [grant(3, verdict_id=10)]), 0)
    assert decide(core, 3) == WAITS_FOR_LEASE


def test_every_claim_must_be_decided_before_any_of_them_moves(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1, parts=(0,)))
    core.on_safe_chunk(chunk(11, first_tick=1, parts=(1,), claim=CLAIM + 1))
    other = grant(1, Decision.UNDECIDED, claim=CLAIM + 1)
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10), other]), 0)
    assert decide(core, 1) == WAITS_FOR_LEASE
    other = grant(1, verdict_id=11, claim=CLAIM + 1)
    core.on_lease(lease(2, 1, [grant(1, verdict_id=10), other]), 0)
    plan = decide(core, 1)
    assert isinstance(plan, TickPlan)
    assert plan.acted == (executed(10, 0), executed(11, 0))


def test_waiting_changes_nothing(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    for _ in range(5):
        core.on_lease(lease(1, 1, [grant(1, Decision.UNDECIDED)]), 0)
        assert decide(core, 1) == WAITS_FOR_LEASE
    core.on_lease(lease(2, 1, [grant(1, verdict_id=10)]), 0)
    assert ran(decide(core, 1)) == executed(10, 0)


def test_a_held_stop_needs_no_lease_to_come_to_standstill(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_stop(stop(5))
    plan = decide(core, 2, is_still=False)
    assert isinstance(plan, TickPlan) and plan.acted[0].hold == Hold.STOPPED
    assert decide(core, 3, is_still=True) == PAUSED


def test_a_world_paused_by_a_stop_ignores_a_decided_lease(core: HalCore) -> None:
    core.on_stop(stop(5))
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    assert decide(core, 1) == PAUSED


def test_a_released_claim_lets_the_world_come_to_standstill_and_pause(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1, horizon=9))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_lease(lease(2, 2, []), 0)
    plan = decide(core, 2, is_still=False)
    assert isinstance(plan, TickPlan) and plan.acted[0].hold == Hold.NOT_GRANTED
    assert decide(core, 3, is_still=True) == PAUSED


def test_grants_of_a_gate_that_is_not_armed_count_for_nothing(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    stopped = lease(1, 1, [grant(1, verdict_id=10)], state=GateState.STOPPED)
    core.on_lease(stopped, 0)
    assert decide(core, 1) == PAUSED


def test_a_grant_for_another_tick_than_the_lease_says_does_not_count(core: HalCore) -> None:
    core.on_safe_chunk(chunk(10, first_tick=2))
    core.on_lease(lease(1, 2, [grant(1, verdict_id=10)]), 0)
    assert decide(core, 2) == WAITS_FOR_LEASE


def test_a_reset_steps_although_the_robot_stands_still(core: HalCore) -> None:
    assert decide(core, 1) == PAUSED
    core.set_resetting(True)
    plan = decide(core, 1)
    assert isinstance(plan, TickPlan) and plan.acted[0].hold == Hold.RESETTING
    core.set_resetting(False)
    assert decide(core, 2) == PAUSED


def test_a_new_claim_may_continue_the_row_of_one_that_ended_while_the_world_stood(
    core: HalCore,
) -> None:
    core.on_safe_chunk(chunk(10, first_tick=1))
    core.on_lease(lease(1, 1, [grant(1, verdict_id=10)]), 0)
    decide(core, 1)
    core.on_lease(lease(1, 2, epoch=EPOCH + 1), 0)
    assert decide(core, 2) == PAUSED
    core.on_safe_chunk(
        chunk(11, first_tick=2, after=executed(10, 0), claim=CLAIM + 1, epoch=EPOCH + 1)
    )
    after = grant(2, verdict_id=11, claim=CLAIM + 1)
    core.on_lease(lease(2, 2, [after], epoch=EPOCH + 1), 0)
    assert ran(decide(core, 2)) == executed(11, 0)
