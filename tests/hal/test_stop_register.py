"""When a HAL holds a stop, repeats it, and lets it go."""

from __future__ import annotations

import pytest

from fairlead.hal.stop_register import MAX_STOPS, StopRegister
from fairlead.messages import GateState
from tests.hal.gate_messages import EPOCH, lease, stop

STOP = 5


@pytest.fixture
def register() -> StopRegister:
    return StopRegister()


def ids(register: StopRegister) -> list[int]:
    """Ids of the stops held now."""
    return [held.stop_id for held in register.held]


def test_a_stop_is_held_until_the_gate_that_listed_it_lists_it_no_longer(
    register: StopRegister,
) -> None:
    register.hold(stop(STOP))
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    assert register.any_held
    register.on_lease(lease(2, 2, state=GateState.DISARMED))
    assert (register.any_held, register.to_repeat()) == (False, ())
    assert register.hold(stop(STOP)) == "stop already reset"


def test_another_gate_that_is_not_armed_does_not_end_a_stop(register: StopRegister) -> None:
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(1, 2, state=GateState.DISARMED, epoch=EPOCH + 1))
    assert register.any_held
    register.on_lease(lease(1, 3, epoch=EPOCH + 2))
    assert not register.any_held


def test_thousands_of_stops_cost_no_more_than_a_few_and_end_with_resets(
    register: StopRegister,
) -> None:
    for stop_id in range(1, 3000):
        register.hold(stop(stop_id))
    ((cause, detail),) = register.demanded
    assert (cause, detail) == ("more stops than can be held", "16 are held already")
    register.raised(cause, stop(9999))
    for stop_id in range(1, 3000):
        assert register.hold(stop(stop_id)) in ("stop already held", "more stops than can be held")
    assert ids(register) == [*range(1, MAX_STOPS + 1), 9999]
    assert len(register.to_repeat()) == MAX_STOPS + 1
    listed = lease(1, 1, state=GateState.STOPPED, stops=[*range(1, MAX_STOPS)])
    register.on_lease(listed)
    register.on_lease(lease(2, 2, state=GateState.STOPPED, stops=[MAX_STOPS, 9999]))
    assert ids(register) == [MAX_STOPS, 9999], "what could not be kept holds until 9999 is reset"
    register.on_lease(lease(3, 3, state=GateState.DISARMED))
    assert not register.any_held


def test_an_armed_lease_of_the_same_epoch_does_not_end_a_stop(register: StopRegister) -> None:
    register.hold(stop(STOP))
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(2, 2))
    assert register.any_held


def test_an_armed_lease_of_another_epoch_does_not_end_a_stop_the_gate_never_listed(
    register: StopRegister,
) -> None:
    register.hold(stop(STOP))
    register.on_lease(lease(1, 1, epoch=EPOCH + 1))
    assert register.any_held


def test_a_stop_that_only_a_lease_told_of_is_held_too(register: StopRegister) -> None:
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    assert ids(register) == [STOP]


def test_a_late_copy_of_a_stop_that_was_reset_is_ignored(register: StopRegister) -> None:
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(1, 2, epoch=EPOCH + 1))
    assert register.hold(stop(STOP)) == "stop already reset"
    assert not register.any_held


def test_a_stop_is_repeated_while_the_newest_lease_does_not_list_it(
    register: StopRegister,
) -> None:
    register.hold(stop(STOP))
    assert register.to_repeat() == (stop(STOP),)
    register.on_lease(lease(1, 1, stops=[STOP + 1]))
    assert stop(STOP) in register.to_repeat()
    register.on_lease(lease(2, 1, state=GateState.STOPPED, stops=[STOP]))
    assert stop(STOP) not in register.to_repeat()


def test_a_restarted_gate_is_told_of_a_stop_it_forgot(register: StopRegister) -> None:
    register.hold(stop(STOP))
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(1, 1, state=GateState.LATCHED, epoch=EPOCH + 1))
    assert register.to_repeat() == (stop(STOP),)


def test_one_stop_that_is_reset_leaves_the_other_one_held(register: StopRegister) -> None:
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.hold(stop(STOP + 1))
    register.on_lease(lease(1, 2, epoch=EPOCH + 1))
    assert ids(register) == [STOP + 1]


def test_a_stop_without_an_id_is_held_under_a_fresh_one_once(register: StopRegister) -> None:
    assert register.hold(stop(0)) == "stop without an id"
    assert register.any_held
    ((cause, detail),) = register.demanded
    assert detail == "by operator: test"
    register.raised(cause, stop(STOP))
    register.hold(stop(0))
    assert (ids(register), register.demanded) == ([STOP], ())


def test_a_cause_that_lasts_after_its_stop_was_reset_is_raised_again(
    register: StopRegister,
) -> None:
    register.demand("two gates", "a and b")
    register.raised("two gates", stop(STOP))
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(1, 2, epoch=EPOCH + 1))
    assert not register.any_held
    register.demand("two gates", "a and b")
    assert register.any_held
