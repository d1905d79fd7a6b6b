"""Bytes that nobody means, through a router: what a name may say comes to everybody who hears it.

So gate, assembler, runner and tools read spoiled states, transforms, leases, verdicts and layouts;
a second program with a service's certificate also answers in its place, and declares tokens. (What
is asked, `test_fuzz` spoils.)
"""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from functools import partial

import pytest
import zenoh

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage
from bench.faults.routed_stage import certified_stage
from fairlead.deploy.access import Kind, Rights, rights
from fairlead.errors import FairleadError
from fairlead.wire.bus import Sample
from fairlead.wire.endpoints import Endpoints
from tests.access.party import endpoints_of
from tests.access.spoiled import (
    STILL_RAD,
    check_all_go_on,
    measured,
    session_of,
    spoiled,
)

pytestmark = [pytest.mark.processes, pytest.mark.timeout(600)]

NAMES = ("hal", "safety", "state_assembler", "runner", "operator")
SHORT, LONG = 20, 100
LAST = b"\xff the last"
HEARD_S = 0.5
ODD = ("x" * 200, "%00", "ünïcödé", "a b", "-", "1" * 64, "..", "@v")
"""Ends of tokens' keys."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with certified_stage(tmp_path_factory.mktemp("fuzz")) as stage:
        yield stage


@pytest.fixture
def second(robot: LiveStage, name: str) -> Iterator[zenoh.Session]:
    """A second program with a name's certificate, which keeps to no rule."""
    deployment = robot.client.deployment
    proof = {"transport": endpoints_of(deployment, name).access["transport"]}
    one = Endpoints(connect=[deployment.router_endpoint], mode="client", access=proof)
    with closing(session_of(one.config())) as session:
        yield session


def comes(robot: LiveStage, session: zenoh.Session, key: str) -> bool:
    """Whether a tool hears what is published there, and so what was published before."""
    heard = threading.Event()

    def on_sample(sample: Sample) -> None:
        if sample.payload == LAST:
            heard.set()

    subscription = robot.client.bus.subscribe(key, on_sample)
    session.put(key, LAST, congestion_control=zenoh.CongestionControl.BLOCK)
    came = heard.wait(HEARD_S)
    subscription.undeclare()
    return came


def rows_of(robot: LiveStage, name: str, kind: Kind) -> list[Rights]:
    """What a name may publish, or which tokens it may declare."""
    every = rights(robot.client.deployment.parties)
    return [one for one in every if name in one.write and one.kind == kind]


@pytest.mark.parametrize("each", [SHORT, pytest.param(LONG, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_name_sends_everybody_goes_on(
    robot: LiveStage, second: zenoh.Session, name: str, each: int
) -> None:
    before = measured(robot)
    chance = random.Random(f"{name} {each}")
    for one in rows_of(robot, name, "published"):
        key = one.key.replace("*", "thing")
        for _, text in zip(range(each), spoiled(chance), strict=False):
            second.put(key, text, congestion_control=zenoh.CongestionControl.BLOCK)
            wait_for(partial(comes, robot, second, key), f"a tool hears {key}")
    assert measured(robot) == pytest.approx(before, abs=STILL_RAD), "nothing moved"
    check_all_go_on(robot)


@pytest.mark.parametrize("name", NAMES)
def test_whatever_tokens_a_name_has_everybody_goes_on(
    robot: LiveStage, second: zenoh.Session, name: str
) -> None:
    families = [one.key for one in rows_of(robot, name, "token")]
    with ExitStack() as stack:
        for key in (one.replace("*", end) for one in families for end in ODD):
            token = second.liveliness().declare_token(key)
            stack.callback(token.undeclare)
        check_all_go_on(robot)
    check_all_go_on(robot)


@pytest.mark.parametrize("name", ["hal", "safety", "runner"])
def test_whatever_a_second_replier_says_who_asks_gets_an_answer_or_one_clear_error(
    robot: LiveStage, second: zenoh.Session, name: str
) -> None:
    client, bytes_of = robot.client, spoiled(random.Random(name))
    answered: list[str] = []

    def reply(query: zenoh.Query) -> None:
        answered.append(str(query.key_expr))
        with query:
            query.reply(query.key_expr, next(bytes_of))

    parties = client.deployment.parties
    for one in rights(parties):
        if one.kind == "query" and name in one.read:
            direct = zenoh.handlers.Callback(reply, indirect=False)
            second.declare_queryable(one.key, direct)
    asked: dict[str, list[Callable[[], object]]] = {
        "hal": [client.hal_status],
        "safety": [client.gate_status, client.disarm, lambda: client.reset(1)],
        "runner": [lambda: client.goal_feedback("runner")],
    }
    for _ in range(SHORT):
        for call in asked[name]:
            with suppress(FairleadError):
                call()
    second.close()  # type: ignore[no-untyped-call]
    assert answered, "it was asked"
    check_all_go_on(robot)


def test_it_came_to_everybody_and_after_all_of_that_the_robot_moves(robot: LiveStage) -> None:
    assert dict(robot.client.gate_status().counters)["G001"] > 10 * SHORT
    goal = robot.start_moving()
    robot.finish(goal)
