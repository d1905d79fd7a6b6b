"""A goal without a claim yet ends with the arming in which it was accepted."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from fairlead.messages import GateState, GoalResult
from tests.runner.policy_servers import OpenpiServer, openpi_actions
from tests.runner.scripted_robot import CLAIM, EPOCH, lease, rows
from tests.runner.scripted_world import ScriptedWorld

pytestmark = pytest.mark.processes

Loading = tuple[ScriptedWorld, int, threading.Event]
STATES = [GateState.STOPPED, GateState.LATCHED, GateState.DISARMED]


@pytest.fixture
def loading(make_world: Callable[..., ScriptedWorld]) -> Iterator[Loading]:
    """A goal that was accepted by an armed gate, and whose policy loads until told."""
    loaded = threading.Event()

    def slow(request: object, number: int) -> bytes:
        loaded.wait()
        return openpi_actions(rows())

    server = OpenpiServer(slow)
    world = make_world()
    try:
        world.start_runner({"backend": "openpi", "options": {
            "address": server.address, "start": "serve", "connect_timeout_s": 4,
            "answer_timeout_s": 4}})  # fmt: skip
        world.gate_turns(GateState.ARMED)
        goal = world.start_goal()
        world.wait_for(lambda: True if server.requests else None)
        yield world, goal, loaded
    finally:
        loaded.set()
        server.close()


def ended(world: ScriptedWorld, goal: int, every: Callable[[], None] | None = None) -> GoalResult:
    result = world.result(goal, every).result
    assert result is not None
    return result


@pytest.mark.parametrize("state", STATES)
def test_a_gate_that_is_armed_no_more_ends_a_goal_whose_policy_loads(
    loading: Loading, state: GateState
) -> None:
    world, goal, loaded = loading
    world.gate_turns(state)
    end = ended(world, goal, every=lambda: world.publish_lease(state))
    assert (end.outcome, end.kind, end.detail) == (
        "failed", "claim_lost", "no claim was taken: the gate has not stayed armed since the goal "
        "came (three stops within 60 s; try: fairlead reset 7); give the goal again",
    )  # fmt: skip
    world.gate_turns(GateState.ARMED, EPOCH + 1)
    again = world.start_goal()
    loaded.set()
    world.wait_for(lambda: world.claims or None)
    assert len(world.claims) == 1, "the first goal took none"
    world.cancel(again)
    assert ended(world, again).outcome == "cancelled"


def test_a_gate_that_was_armed_anew_ends_a_goal_whose_policy_loads(loading: Loading) -> None:
    world, goal, _ = loading
    world.gate_turns(GateState.ARMED, EPOCH + 1)
    assert ended(world, goal, every=world.publish_lease).kind == "claim_lost"
    assert world.claims == []


def test_a_claim_of_another_arming_is_given_back_unused(loading: Loading) -> None:
    """However few leases are heard."""
    world, goal, loaded = loading
    world.gate_turns(GateState.ARMED, EPOCH + 1)
    loaded.set()
    end = ended(world, goal)
    assert (end.outcome, end.kind, end.detail) == (
        "failed", "claim_lost", "no claim was taken: the gate has not stayed armed since the goal "
        "came; give the goal again",
    )  # fmt: skip
    assert (world.released, world.chunks) == ([CLAIM], [])


def test_a_goal_that_came_before_the_gate_was_armed_takes_no_claim(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    world = make_world()
    world.start_runner({"backend": "constant", "options": {"row": [0.5] * 12}})
    world.gate_turns(GateState.DISARMED)
    goal = world.start_goal()
    world.gate_turns(GateState.ARMED, EPOCH + 1)
    end = ended(world, goal)
    assert end.detail.startswith("no claim was taken: the gate was not armed when the goal came")
    assert world.chunks == []


def test_a_late_lease_of_the_arming_before_ends_no_goal(loading: Loading) -> None:
    world, goal, loaded = loading
    world.publish(lease(1, epoch=EPOCH - 1, state=GateState.DISARMED, claims=()))
    loaded.set()
    world.wait_for(lambda: world.claims or None)
    world.cancel(goal)
    assert ended(world, goal).outcome == "cancelled"
