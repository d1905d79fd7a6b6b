"""Who has stolen a certificate speaks in its name beside its owner, while the robot moves.

What HAL and gate know by themselves gives the forger away: the robot holds, status and log say why.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from typing import TypeVar

import pytest
from msgspec.structs import replace

from bench.equipment.live_robot import wait_for
from bench.equipment.mailbox import Mailbox
from bench.equipment.motion_log import TICK_MS, hold_delay_ms
from bench.faults.live_stage import LiveStage, live_stage
from bench.faults.routed_stage import certified_stage
from fairlead.deploy.access import OPERATOR
from fairlead.errors import NoAnswerError, RefusedError
from fairlead.messages import (
    NO_HASH,
    Acted,
    Claim,
    GateState,
    JointState,
    Lease,
    Message,
    Release,
    SafeChunk,
    StopLevel,
)
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]

M = TypeVar("M", bound=Message)

WATCHED_NS = 1_000_000_000
BOUND_MS = 150.0
LEAD_TICKS = 3
FORGED_TICKS = 2
ANSWER_S = 0.5


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with certified_stage(tmp_path_factory.mktemp("stolen")) as stage:
        yield stage


@pytest.fixture(scope="module")
def peers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with live_stage(tmp_path_factory.mktemp("peers")) as stage:
        yield stage


def session_of(robot: LiveStage, name: str) -> ZenohBus:
    """With the certificate of a service, beside the service's own."""
    return ZenohBus(robot.client.deployment.tool_endpoints(name))


def link_to_hal(robot: LiveStage, name: str) -> ZenohBus:
    """On one host, with the password of a service: nobody but the HAL hears it."""
    deployment = robot.client.deployment
    proof = deployment.tool_endpoints(name).access["transport"]
    hal = deployment.services[deployment.hal].listen
    return ZenohBus(Endpoints(connect=[hal], mode="client", access={"transport": proof}))


def newest(robot: LiveStage, key: str, kind: type[M]) -> M:
    """The next message on a key."""
    with closing(Mailbox(robot.client.bus, key, kind)) as mailbox:
        return mailbox.wait_for()


def forged_lease(robot: LiveStage) -> tuple[str, Message]:
    """Far ahead of the gate's own, and granting for ever."""
    key = robot.client.keys.lease
    lease = newest(robot, key, Lease)
    grants = tuple(replace(one, until_tick=2**40) for one in lease.grants)
    return key, replace(lease, lease_seq=lease.lease_seq + 2**40, grants=grants)


def forged_rows(robot: LiveStage) -> tuple[str, Message]:
    """Of a later verdict than the gate's, going on from the row that acts then."""
    rows = newest(robot, robot.client.keys.every_safe, SafeChunk)
    after = Acted(hold=0, verdict_id=rows.verdict_id, row=LEAD_TICKS - 1)
    ahead = {"verdict_id": rows.verdict_id + 1000, "first_tick": rows.first_tick + LEAD_TICKS}
    return robot.client.keys.safe(rows.source), replace(rows, after=after, **ahead)


def forged_state(robot: LiveStage) -> tuple[str, Message]:
    """Of the tick that comes next."""
    key = robot.client.keys.joints
    state = newest(robot, key, JointState)
    return key, replace(state, tick=state.tick + 1, stamp_ns=state.stamp_ns + 1)


def forged_stop(robot: LiveStage) -> tuple[str, Message]:
    """By nobody known."""
    return robot.client.keys.stop, StopLevel(stop_id=23, by="mallory@lab (program)", reason="now")


@dataclass(frozen=True)
class Forgery:
    """What the owner of a certificate would not say, and what HAL and gate say of it."""

    owner: str
    make: Callable[[LiveStage], tuple[str, Message]]
    hal: str
    gate: str


FORGERIES = (
    Forgery("safety", forged_lease, "", "two gates serve this robot: lease "),
    Forgery("safety", forged_rows, "", "two gates serve this robot: "),
    Forgery("hal", forged_state, "two HALs: ", "two HALs"),
    Forgery(OPERATOR, forged_stop, "(now)", "stopped: by mallory@lab (program): now"),
)


def log_of(robot: LiveStage, service: str) -> str:
    return (robot.robot.scratch.state_dir / "logs" / f"{service}.log").read_text(encoding="utf-8")


def forge(robot: LiveStage, bus: ZenohBus, forgery: Forgery) -> None:
    """While the robot moves: it holds in time, and says why."""
    robot.start_moving()
    key, message = forgery.make(robot)
    publisher = bus.publisher(key, type(message), Qos.HOT)
    injected_ns = time.monotonic_ns()
    publisher.put(message)
    delay_ms = hold_delay_ms(robot.motion_ended(injected_ns), injected_ns)
    gate, hal = robot.client.gate_status(), robot.client.hal_status()
    print(f"held after {delay_ms:.0f} ms; gate: {gate.cause}; HAL: {hal.state} {hal.detail}")
    begins_ms = LEAD_TICKS * TICK_MS if isinstance(message, SafeChunk) else 0.0
    assert delay_ms < begins_ms + BOUND_MS
    assert gate.state in (GateState.STOPPED, GateState.LATCHED)
    assert forgery.gate in gate.cause
    assert forgery.hal in hal.detail
    wait_for(lambda: forgery.gate in log_of(robot, "safety"), "the gate's log has it")
    if forgery.hal.startswith("two "):
        wait_for(lambda: forgery.hal in log_of(robot, "hal"), "the HAL's log has it")
    if isinstance(message, SafeChunk):
        lines = robot.motion.since(injected_ns)
        acted = sum(message.verdict_id in line.verdicts for line in lines)
        print(f"forged rows acted in {acted} ticks")
        assert acted <= FORGED_TICKS


def test_without_a_forger_the_robot_goes_on(robot: LiveStage) -> None:
    goal, began_ns = robot.start_moving(), time.monotonic_ns()
    with closing(session_of(robot, "safety")):
        robot.no_hold_between(began_ns, began_ns + WATCHED_NS)
    robot.finish(goal)


@pytest.mark.parametrize("forgery", FORGERIES, ids=lambda one: one.make.__name__)
def test_what_a_forger_says_behind_a_router_holds_the_robot_and_is_named(
    robot: LiveStage, forgery: Forgery
) -> None:
    with closing(session_of(robot, forgery.owner)) as bus:
        forge(robot, bus, forgery)


@pytest.mark.parametrize(
    "forgery",
    [
        Forgery("safety", forged_lease, "two gates: lease ", "by hal: two gates: lease "),
        Forgery("safety", forged_rows, "", "two gates"),
    ],
    ids=lambda one: one.make.__name__,
)
def test_what_only_the_hal_hears_of_a_forger_holds_the_robot_and_is_named(
    peers: LiveStage, forgery: Forgery
) -> None:
    with closing(link_to_hal(peers, forgery.owner)) as bus:
        forge(peers, bus, forgery)


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
