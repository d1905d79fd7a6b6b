"""Who has no right to it tries to move the robot, or to stop it."""

from __future__ import annotations

import time
from concurrent.futures import Future
from contextlib import closing

import msgspec

from bench.equipment.bad_certificates import UNKNOWN_NAME
from bench.faults.live_stage import LiveStage
from bench.faults.machine_faults import NO_EFFECT, WATCHED_NS
from bench.faults.routed_stage import CertifiedStage
from bench.faults.row import Row, Shot
from fairlead.errors import NoAnswerError, TransportError
from fairlead.messages import (
    ActionChunk,
    GateState,
    HalStatus,
    JointState,
    Lease,
    Message,
    Reset,
    SafeChunk,
    StopLevel,
    encode,
)
from fairlead.operate.goal_hearing import Progress
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

ANSWER_S = 0.5
STOP_ID = 23


def no_right(robot: LiveStage) -> Shot:
    """Who has the runner's password, and keeps to no rule, tells HAL and gate what others say.

    Each of these messages would end the motion if it were taken.
    """
    deployment = robot.client.deployment
    proof = deployment.tool_endpoints(deployment.runners[0]).access["transport"]
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    for service in (deployment.hal, deployment.only("safety")):
        listen = deployment.services[service].listen
        one = Endpoints(connect=[listen], mode="client", access={"transport": proof})
        with closing(ZenohBus(one)) as bus:
            _forge(robot, bus)
    return _unmoved(robot, goal, injected_ns, "forged leases, rows, states, stops, a reset")


def default_peer(robot: LiveStage) -> Shot:
    """It dials every service, and gets no link."""
    deployment = robot.client.deployment
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    with closing(ZenohBus(Endpoints(connect=deployment.tool_endpoints().connect))) as bus:
        seen: list[str] = []
        bus.watch_tokens(robot.client.keys.every_alive, lambda key, alive: seen.append(key))
        _forge(robot, bus)
        shot = _unmoved(robot, goal, injected_ns, "no link")
        assert not seen, seen
    return shot


def bad_certificate(robot: CertifiedStage) -> Shot:
    """Who shows an operator's that has ended or is revoked, another robot's, or a wrong name's."""
    router = [robot.client.deployment.router_endpoint]
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    linked = []
    for kind, proof in robot.proofs.items():
        try:
            bus = ZenohBus(Endpoints(connect=router, mode="client", access=proof))
        except TransportError:
            continue
        with closing(bus):
            linked.append(kind)
            _forge(robot, bus)
    assert linked == [UNKNOWN_NAME], linked
    return _unmoved(robot, goal, injected_ns, "no link; with a wrong name one that nothing passes")


def _forge(robot: LiveStage, bus: ZenohBus) -> None:
    keys = robot.client.keys
    lease = msgspec.structs.replace(
        robot.leases[-1][1],
        lease_seq=2**40,
        state=GateState.STOPPED,
        grants=(),
        stop_ids=(STOP_ID,),
    )
    stop = StopLevel(stop_id=STOP_ID, by="stranger", reason="forged")
    said: tuple[tuple[str, type[Message], bytes], ...] = (
        (keys.lease, Lease, encode(lease)),
        (keys.stop, StopLevel, encode(stop)),
        (keys.safe("stranger"), SafeChunk, b"\xff"),
        (keys.candidate("stranger"), ActionChunk, b"\xff"),
        (keys.joints, JointState, b"\xff"),
        (keys.hal_status, HalStatus, b"\xff"),
    )
    for key, kind, payload in said:
        bus.publisher(key, kind, Qos.HOT).put_bytes(payload)
    try:
        bus.query(keys.gate_command("reset"), Reset(by="stranger", id=STOP_ID), ANSWER_S)
    except NoAnswerError:
        return
    raise AssertionError("the gate answered a reset")


def _unmoved(robot: LiveStage, goal: Future[Progress], injected_ns: int, note: str) -> Shot:
    ticks = robot.no_hold_between(injected_ns, time.monotonic_ns() + WATCHED_NS)
    status = robot.client.gate_status()
    assert (status.state, status.stop_ids) == (GateState.ARMED, ()), status
    ended_ns = time.monotonic_ns()
    robot.finish(goal)
    return Shot(None, injected_ns, ended_ns, note=f"{ticks} ticks, none held: {note}")


ROWS = (
    Row(23, "who has the runner's password sends leases, rows, states, stops, a reset", NO_EFFECT,
        None, "robot", no_right),
    Row(24, "a peer with a default configuration sends the same", "no link; no tick is held", None,
        "robot", default_peer),
    Row(25, "who has an expired, revoked or wrong-name certificate sends the same",
        "no link, or nothing passes it; no tick is held", None, "certified",
        bad_certificate),
)  # fmt: skip
