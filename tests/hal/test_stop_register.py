"""When a HAL holds a stop, repeats it, and lets it go."""

from __future__ import annotations

import pytest

from fairlead.hal.stop_register import StopRegister
from fairlead.messages import GateState
from tests.hal.gate_messages import EPOCH, lease, stop

STOP = 5


@pytest.fixture
def register() -> StopRegister:
    return StopRegister()


def ids(register: StopRegister) -> list[int]:
    """Ids of the stops held now."""
    return [held.stop_id for held in register.held]


def test_a_stop_is_held_until_the_operator_reset_it_and_armed_again(
    register: StopRegister,
) -> None:
    register.hold(stop(STOP))
    register.on_lease(lease(1, 1, state=GateState.STOPPED, stops=[STOP]))
    register.on_lease(lease(2, 2, state=GateState.DISARMED))
    assert register.any_held
    register.on_lease(lease(1, 3, epoch=EPOCH + 1))
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
