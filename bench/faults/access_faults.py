"""Who has no right to it tries to move the robot, or to stop it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

from msgspec.structs import replace

from bench.equipment.bad_certificates import UNKNOWN_NAME
from bench.faults.forger_faults import (
    forged_lease,
    forged_rows,
    forged_state,
    forged_stop,
    newest,
)
from bench.faults.live_stage import LiveStage
from bench.faults.machine_faults import NO_EFFECT, WATCHED_NS
from bench.faults.routed_stage import CertifiedStage
from bench.faults.row import Row, Shot
from fairlead.errors import NoAnswerError, RefusedError, TransportError
from fairlead.messages import (
    ActionChunk,
    Disarm,
    GateState,
    HalStatus,
    Message,
    Release,
    Reset,
    ResetEpisode,
)
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

ANSWER_S = 0.5
STRANGER = "stranger"
COUNTED = ("G001", "G002")
"""Under which the gate counts frames that it cannot read, and those of another HAL or robot."""


@dataclass(frozen=True)
class Attempt:
    """A well-formed message that, wherever it is taken, ends the motion or at least is answered.

    Attributes:
        make: its key, and the message as it fits what the robot does now.
        is_query: it is asked, not published.
        ends: it ends the motion; a moving robot answers the others why not.
        of_runner: a runner has the right to it.
    """

    make: Callable[[LiveStage], tuple[str, Message]]
    is_query: bool = False
    ends: bool = True
    of_runner: bool = False

    def send(self, robot: LiveStage, buses: Sequence[ZenohBus]) -> bool:
        """From each session; whether somebody answered."""
        key, message = self.make(robot)
        if self.is_query:
            return True in [_is_answered(bus, key, message) for bus in buses]
        for bus in buses:
            bus.publisher(key, type(message), Qos.HOT).put(message)
        return False


def _is_answered(bus: ZenohBus, key: str, message: Message) -> bool:
    try:
        bus.query(key, message, ANSWER_S)
    except NoAnswerError:
        return False
    except RefusedError:
        return True
    return True


def forged_status(robot: LiveStage) -> tuple[str, Message]:
    """The HAL reports a fault."""
    key = robot.client.keys.hal_status
    return key, replace(newest(robot, key, HalStatus), state="fault", detail="forged")


def forged_chunk(robot: LiveStage) -> tuple[str, Message]:
    """Of a later number than the runner's next ones, which are old after it."""
    chunk = newest(robot, robot.client.keys.every_candidate, ActionChunk)
    return robot.client.keys.candidate(chunk.source), replace(chunk, seq=chunk.seq + 20)


def forged_release(robot: LiveStage) -> tuple[str, Message]:
    """The runner gives its claim back."""
    [claim] = robot.client.gate_status().claims
    said = Release(source=claim.source, claim_id=claim.claim_id)
    return robot.client.keys.release(claim.source), said


def disarm(robot: LiveStage) -> tuple[str, Message]:
    """The gate is to disarm."""
    return robot.client.keys.gate_command("disarm"), Disarm(by=STRANGER)


def reset(robot: LiveStage) -> tuple[str, Message]:
    """Of no stop that there is."""
    return robot.client.keys.gate_command("reset"), Reset(by=STRANGER, id=1)


def reset_episode(robot: LiveStage) -> tuple[str, Message]:
    """The HAL is to begin anew."""
    return robot.client.keys.hal_command("reset_episode"), ResetEpisode(seed=0, by=STRANGER)


ATTEMPTS = (
    Attempt(forged_lease),
    Attempt(forged_rows),
    Attempt(forged_state),
    Attempt(forged_stop),
    Attempt(forged_status),
    Attempt(forged_chunk, of_runner=True),
    Attempt(forged_release, is_query=True, of_runner=True),
    Attempt(disarm, is_query=True),
    Attempt(reset, is_query=True, ends=False),
    Attempt(reset_episode, is_query=True, ends=False),
)


def diallers(robot: LiveStage) -> Sequence[Endpoints]:
    """Who has the runner's password, and keeps to no rule, dials HAL and gate."""
    deployment = robot.client.deployment
    access = deployment.tool_endpoints(deployment.runners[0]).access
    proof = {name: part for name, part in access.items() if name == "transport"}
    listens = [deployment.listen(one) for one in (deployment.hal, deployment.only("safety"))]
    return [Endpoints(connect=[listen], mode="client", access=proof) for listen in listens]


def default_peers(robot: LiveStage) -> Sequence[Endpoints]:
    """Whoever knows nothing of fairlead dials every service."""
    return [Endpoints(connect=robot.client.deployment.tool_endpoints().connect)]


def no_right(robot: LiveStage) -> Shot:
    """Who has the runner's password tells HAL and gate what others say."""
    attempts = [one for one in ATTEMPTS if not one.of_runner]
    return _unmoved(robot, diallers(robot), attempts, "forged leases, rows, states, stops, a reset")


def default_peer(robot: LiveStage) -> Shot:
    """It dials every service, and gets no link."""
    return _unmoved(robot, default_peers(robot), ATTEMPTS, "no link", sees_nobody=True)


def bad_certificate(robot: CertifiedStage) -> Shot:
    """Who shows an operator's that has ended or is revoked, another robot's, or a wrong name's."""
    router = [robot.client.deployment.router_endpoint]
    linked = {}
    for kind, proof in robot.proofs.items():
        one = Endpoints(connect=router, mode="client", access=proof)
        try:
            ZenohBus(one).close()
        except TransportError:
            continue
        linked[kind] = one
    assert list(linked) == [UNKNOWN_NAME], list(linked)
    note = "no link; with a wrong name one that nothing passes"
    return _unmoved(robot, [*linked.values()], ATTEMPTS, note, sees_nobody=True)


def _unmoved(
    robot: LiveStage,
    strangers: Sequence[Endpoints],
    attempts: Sequence[Attempt],
    note: str,
    sees_nobody: bool = False,
) -> Shot:
    """They send it all, twice; nobody takes or answers it.

    Args:
        sees_nobody: they do not see who is alive, either.
    """
    goal = robot.start_moving()
    counted, seen = _counted(robot), list[str]()
    injected_ns = time.monotonic_ns()
    with ExitStack() as stack:
        buses = [stack.enter_context(closing(ZenohBus(one))) for one in strangers]
        for bus in buses:
            bus.watch_tokens(robot.client.keys.every_alive, lambda key, alive: seen.append(key))
        for one in [*attempts, *attempts]:
            assert not one.send(robot, buses), f"{one.make.__name__} was answered"
        ticks = robot.no_hold_between(injected_ns, time.monotonic_ns() + WATCHED_NS)
    status, detail = robot.client.gate_status(), robot.client.hal_status().detail
    assert (status.state, status.stop_ids, detail) == (GateState.ARMED, (), ""), (status, detail)
    assert _counted(robot) == counted, "the gate heard what it could not take"
    assert not (sees_nobody and seen), seen
    ended_ns = time.monotonic_ns()
    robot.finish(goal)
    return Shot(None, injected_ns, ended_ns, note=f"{ticks} ticks, none held: {note}")


def _counted(robot: LiveStage) -> list[int]:
    counters = dict(robot.client.gate_status().counters)
    return [counters.get(code, 0) for code in COUNTED]


ROWS = (
    Row(23, "who has the runner's password sends leases, rows, states, stops, a reset", NO_EFFECT,
        None, "robot", no_right),
    Row(24, "a peer with a default configuration sends the same", "no link; no tick is held", None,
        "robot", default_peer),
    Row(25, "who has an expired, revoked or wrong-name certificate sends the same",
        "no link, or nothing passes it; no tick is held", None, "certified",
        bad_certificate),
)  # fmt: skip
