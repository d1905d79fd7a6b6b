"""One large message of whoever has a certificate or password takes neither the robot nor memory."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import zenoh

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage, live_stage
from bench.faults.machine_faults import WATCHED_NS
from bench.faults.routed_stage import certified_stage
from fairlead.deploy.access import OPERATOR
from fairlead.deploy.registry import Registry
from fairlead.messages import GateState
from fairlead.wire.endpoints import MESSAGE_MAX, Endpoints
from fairlead_tools.supervisor.this_host import free_ports
from tests.access.party import endpoints_of
from tests.access.spoiled import session_of

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

LARGE = bytes(1_000_000)
TOO_LARGE = bytes(3 * MESSAGE_MAX)
BLOCK = zenoh.CongestionControl.BLOCK
LAST = b"the last"


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with certified_stage(tmp_path_factory.mktemp("large")) as stage:
        yield stage


@pytest.mark.parametrize("is_query", [False, True])
def test_what_has_no_room_on_the_gates_link_holds_no_robot_and_cuts_nobody_off(
    robot: LiveStage, is_query: bool
) -> None:
    deployment, keys = robot.client.deployment, robot.client.keys
    proof = {"transport": endpoints_of(deployment, "runner").access["transport"]}
    router = [deployment.router_endpoint]
    goal, began_ns = robot.start_moving(), time.monotonic_ns()
    with closing(session_of(Endpoints(connect=router, mode="client", access=proof).config())) as s:
        if is_query:
            s.get(keys.gate_status, payload=LARGE, timeout=1.0)
        else:
            s.put(keys.candidate("runner"), LARGE, congestion_control=BLOCK)
        robot.no_hold_between(began_ns, time.monotonic_ns() + WATCHED_NS)
    assert robot.client.gate_status().state == GateState.ARMED
    robot.finish(goal)


def test_the_gate_puts_together_no_message_that_nobody_needs(tmp_path: Path) -> None:
    with live_stage(tmp_path) as robot:
        deployment = robot.client.deployment
        proof = {"transport": endpoints_of(deployment, OPERATOR).access["transport"]}
        gate = [deployment.listen(deployment.only("safety"))]
        one = Endpoints(connect=gate, mode="client", access=proof)
        key = deployment.keys.candidate("x")
        with closing(session_of(one.config())) as session:
            session.put(key, TOO_LARGE, congestion_control=BLOCK)
            wait_for(lambda: is_heard(robot, session, key), "the gate hears what comes after it")
        [entry] = Registry(tmp_path / "registry").entries()
        process = entry.services["safety"].process
        assert process is not None and most_memory(process.pid) < 2 * MESSAGE_MAX


def is_heard(robot: LiveStage, session: zenoh.Session, key: str) -> bool:
    """Whether the gate has met something that it cannot read."""
    session.put(key, LAST, congestion_control=BLOCK)
    return dict(robot.client.gate_status().counters)["G001"] > 0


def most_memory(process: int) -> int:
    """Bytes."""
    [line] = [
        one
        for one in Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines()
        if one.startswith("VmHWM")
    ]
    return 1024 * int(line.split()[1])


def test_what_is_longer_than_any_picture_does_not_come() -> None:
    [port] = free_ports(1)
    place, came, done = f"tcp/127.0.0.1:{port}", list[int](), threading.Event()

    def on_sample(sample: zenoh.Sample) -> None:
        came.append(len(sample.payload))
        if sample.payload.to_bytes() == LAST:
            done.set()

    with (
        closing(session_of(Endpoints(listen=[place]).config())) as reader,
        closing(session_of(Endpoints(connect=[place]).config())) as writer,
    ):
        reader.declare_subscriber("key", on_sample)
        publisher = writer.declare_publisher("key", congestion_control=BLOCK)

        def is_heard_at_all() -> bool:
            publisher.put(b"")
            return bool(came)

        wait_for(is_heard_at_all, "it is heard")
        for text in (bytes(MESSAGE_MAX - 1000), bytes(MESSAGE_MAX + 1), LAST):
            publisher.put(text)
        assert done.wait(60.0)
    assert [one for one in came if one] == [MESSAGE_MAX - 1000, len(LAST)]
