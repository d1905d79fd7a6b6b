"""A thief of a password or certificate, beyond row 49 of the fault matrix (`tests/faults`)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing

import pytest

from bench.equipment.motion_log import TICK_MS
from bench.faults.forger_faults import (
    BOUND_MS,
    LEAD_TICKS,
    Forgery,
    forge,
    forged_epoch,
    forged_lease,
    forged_rows,
)
from bench.faults.live_stage import Changes, LiveStage, live_stage
from bench.faults.routed_stage import certified_stage
from fairlead.errors import NoAnswerError, RefusedError
from fairlead.messages import NO_HASH, Claim, Release
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]

WATCHED_NS = 1_000_000_000
ANSWER_S = 0.5


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with certified_stage(tmp_path_factory.mktemp("stolen")) as stage:
        yield stage


@pytest.fixture(scope="module")
def peers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with live_stage(tmp_path_factory.mktemp("peers"), Changes(access="open")) as stage:
        yield stage


def session_of(robot: LiveStage, name: str) -> ZenohBus:
    """With the certificate of a service, beside the service's own."""
    return ZenohBus(robot.client.deployment.tool_endpoints(name))


def link_to_hal(robot: LiveStage) -> ZenohBus:
    """On one host nobody but the HAL hears it."""
    deployment = robot.client.deployment
    hal = deployment.listen(deployment.hal)
    return ZenohBus(Endpoints(connect=[hal]))  # a client is passed on to others


def test_without_a_forger_the_robot_goes_on(robot: LiveStage) -> None:
    goal, began_ns = robot.start_moving(), time.monotonic_ns()
    with closing(session_of(robot, "safety")):
        robot.no_hold_between(began_ns, began_ns + WATCHED_NS)
    robot.finish(goal)


@pytest.mark.parametrize(
    "forgery",
    [
        Forgery("safety", forged_lease, "two gates: lease ", "by hal: two gates: lease "),
        Forgery("safety", forged_rows, "", "two gates"),
        # Last: the HAL follows the gate again once that has armed in a later epoch.
        Forgery("safety", forged_epoch, "two gates: lease ", "by hal: two gates: lease "),
    ],
    ids=lambda one: one.make.__name__,
)
def test_what_only_the_hal_hears_of_a_forger_holds_the_robot_and_is_named(
    peers: LiveStage, forgery: Forgery
) -> None:
    with closing(link_to_hal(peers)) as bus:
        shot = forge(peers, bus, forgery)
    print(shot)
    begins_ms = (LEAD_TICKS + 1) * TICK_MS if forgery.make is forged_rows else 0.0
    assert shot.measured_ms is not None and shot.measured_ms < begins_ms + BOUND_MS


def test_a_stolen_runner_claims_and_releases_in_no_name_but_its_own(robot: LiveStage) -> None:
    robot.ready_to_move()
    keys = robot.client.keys
    with (
        robot.client.claim(["base"], source="planner") as claim,
        closing(session_of(robot, "runner")) as bus,
    ):
        theirs = Release(source="planner", claim_id=claim.reply.claim_id, offered_to="runner")
        request = Claim(
            source="planner", skill="s", skill_hash=NO_HASH, robot_hash=NO_HASH, period_ns=1,
            parts=("arm",), chunk_rate_hz=1.0, horizon_max=1, age_max_ticks=1, limits=(),
        )  # fmt: skip
        for key, said in ((keys.release("runner"), theirs), (keys.claim("runner"), request)):
            with pytest.raises(RefusedError, match="asked in the name of planner on the key of"):
                bus.query(key, said, ANSWER_S)
        for key, said in ((keys.release("planner"), theirs), (keys.claim("planner"), request)):
            with pytest.raises(NoAnswerError):
                bus.query(key, said, ANSWER_S)
        assert [one.source for one in robot.client.gate_status().claims] == ["planner"]
