"""An operator's view of one running robot: ask its services, wait for them, stop it."""

from __future__ import annotations

import secrets
import threading
import time
from contextlib import suppress
from types import TracebackType
from typing import TypeVar

from fairlead.deploy.deployment import Deployment
from fairlead.errors import NoAnswerError
from fairlead.keys import last_chunk
from fairlead.messages import (
    NO_HASH,
    Arm,
    ArmReply,
    Cancel,
    Claim,
    ClaimReply,
    Disarm,
    Done,
    GateState,
    GateStatus,
    Goal,
    GoalAccepted,
    GoalFeedback,
    HalStatus,
    Lease,
    Message,
    Release,
    Reset,
    ResetEpisode,
    ResetEpisodeReply,
    StatusQuery,
    StopLevel,
    decode,
)
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead.wire.session import ZenohBus

ALIVE_TIMEOUT_S = 3.0
SEEN_S = 1.0  # links are up, and tokens told, well within
ANSWER_TIMEOUT_S = 3.0  # > LINK_SILENCE_S, else a paused router may arm after "no answer"
EPISODE_TIMEOUT_S = 60.0  # a simulator builds and settles its scene
GATE_FOLLOWS_TIMEOUT_S = 10.0
STOP_REPEAT_S = 0.05
STOP_TIMEOUT_S = 2.0

Reply = TypeVar("Reply", bound=Message)


def alive_services(deployment: Deployment, settle_s: float = SEEN_S) -> frozenset[str]:
    """Services whose liveliness token is seen within ``settle_s``: a hint for people.

    Raises:
        TransportError: if the session cannot be opened.
    """
    with RobotClient(deployment) as client:
        with suppress(NoAnswerError):
            client.wait_alive(*deployment.services, timeout_s=settle_s)
        return client.alive


class RobotClient:
    """Queries to the services of one deployment.

    Args:
        deployment: whose services.
        bus: an open transport; None opens (and `close` closes) a Zenoh session.
        by: who is asking, for the logs of those who answer.

    Raises:
        TransportError: if the session cannot be opened.
    """

    def __init__(
        self, deployment: Deployment, bus: Bus | None = None, by: str = "fairlead"
    ) -> None:
        self.deployment = deployment
        self.keys = deployment.keys
        self.bus: Bus = bus if bus is not None else ZenohBus(deployment.tool_endpoints())
        self.gate = deployment.only("safety")
        self.hal = deployment.hal
        self._by = by
        self._alive: set[str] = set()
        self._changed = threading.Condition()
        self.bus.watch_tokens(self.keys.every_alive, self._on_token)

    def __enter__(self) -> RobotClient:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the session; the services are left as they are."""
        self.bus.close()

    # --- who is there ---------------------------------------------------------------

    @property
    def alive(self) -> frozenset[str]:
        """Services whose liveliness token is seen now: a hint for people."""
        with self._changed:
            return frozenset(self._alive)

    def wait_alive(self, *services: str, timeout_s: float = ALIVE_TIMEOUT_S) -> None:
        """Wait until these services are seen.

        Raises:
            NoAnswerError: naming those that are missing.
        """
        wanted = set(services)
        with self._changed:
            if self._changed.wait_for(lambda: wanted <= self._alive, timeout_s):
                return
            unseen = sorted(wanted - self._alive)
        missing = ", ".join(self.deployment.with_host(name) for name in unseen)
        raise NoAnswerError(
            f"robot {self.deployment.id}: {missing} not seen within {timeout_s:g} s; "
            "is it running, or starting again? see: fairlead ps, fairlead logs; "
            "start with: fairlead up DEPLOYMENT"
        )

    def _on_token(self, key: str, is_alive: bool) -> None:
        with self._changed:
            (self._alive.add if is_alive else self._alive.discard)(last_chunk(key))
            self._changed.notify_all()

    # --- the gate -------------------------------------------------------------------

    def gate_status(self) -> GateStatus:
        """What the gate is doing and why."""
        return self._ask(self.gate, self.keys.gate_status, StatusQuery(), GateStatus)

    def arm(self) -> ArmReply:
        """Let claims be granted. `RefusedError` says what stands in the way."""
        return self._ask(self.gate, self.keys.gate_command("arm"), Arm(by=self._by), ArmReply)

    def disarm(self) -> Done:
        """End every claim; the robot holds."""
        return self._ask(self.gate, self.keys.gate_command("disarm"), Disarm(by=self._by), Done)

    def reset(self, stop_or_latch_id: int) -> Done:
        """Acknowledge one stop or latch; leads to disarmed, never to motion."""
        request = Reset(by=self._by, id=stop_or_latch_id)
        return self._ask(self.gate, self.keys.gate_command("reset"), request, Done)

    def claim(self, request: Claim) -> ClaimReply:
        """Ask for parts of the robot, as a runner does. `RefusedError` says why not."""
        return self._ask(self.gate, self.keys.gate_command("claim"), request, ClaimReply)

    def release(self, source: str, claim_id: int) -> Done:
        """Give a claim back; its parts hold."""
        request = Release(source=source, claim_id=claim_id)
        return self._ask(self.gate, self.keys.gate_command("release"), request, Done)

    def following_gate(self) -> GateStatus | None:
        """The gate's status, if it has left boot and has a state of the HAL that runs now."""
        gate, hal = self.gate_status(), self.hal_status()
        follows = gate.session == hal.session and gate.state_tick > 0
        return gate if gate.state != GateState.BOOT and follows else None

    def wait_gate_follows(self, timeout_s: float = GATE_FOLLOWS_TIMEOUT_S) -> GateStatus:
        """Wait until the gate has left boot and has a state of the HAL that runs now.

        Raises:
            NoAnswerError: saying what it waits for.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            following = self.following_gate()
            if following is not None:
                return following
            if time.monotonic() > deadline:
                gate = self.gate_status()
                raise NoAnswerError(
                    f"robot {self.deployment.id}: the gate does not follow the HAL after "
                    f"{timeout_s:g} s: {gate.cause or GateState(gate.state).name.lower()}"
                )
            time.sleep(STOP_REPEAT_S)

    # --- a stop ---------------------------------------------------------------------

    def stop(self, reason: str) -> int:
        """Request a protective stop, repeated until a lease lists it.

        Returns:
            The stop's id, which a reset must cite.

        Raises:
            NoAnswerError: no lease listed it in time; the robot may still move.
        """
        stop_id = secrets.randbits(63) + 1
        listed = threading.Event()

        def on_lease(sample: Sample) -> None:
            if stop_id in decode(Lease, sample.payload).stop_ids:
                listed.set()

        subscription = self.bus.subscribe(self.keys.lease, on_lease)
        publisher = self.bus.publisher(self.keys.stop, StopLevel, Qos.HOT)
        message = StopLevel(stop_id=stop_id, by=self._by, reason=reason)
        due = time.monotonic()
        deadline = due + STOP_TIMEOUT_S
        while True:
            publisher.put(message)
            due += STOP_REPEAT_S  # not from when the wait ended: that would add up
            if listed.wait(max(0.0, due - time.monotonic())):
                subscription.undeclare()
                return stop_id
            if time.monotonic() > deadline:
                raise NoAnswerError(
                    f"robot {self.deployment.id}: no lease lists the stop after "
                    f"{STOP_TIMEOUT_S:g} s: THE GATE IS NOT ANSWERING; the HAL holds on its own "
                    "75 ms after the last lease; see: fairlead ps"
                )

    # --- the HAL and the runners -----------------------------------------------------

    def hal_status(self) -> HalStatus:
        """Who the robot is, what it has, and how it is paced."""
        return self._ask(self.hal, self.keys.hal_status, StatusQuery(), HalStatus)

    def reset_episode(self, seed: int) -> ResetEpisodeReply:
        """Start a new simulated episode; refused unless disarmed."""
        key = self.keys.hal_command("reset_episode")
        request = ResetEpisode(seed=seed)
        return self._ask(self.hal, key, request, ResetEpisodeReply, EPISODE_TIMEOUT_S)

    def goal(
        self, runner: str, skill: str, prompt: str, deadline_ticks: int, stall_timeout_s: float
    ) -> int:
        """Hand a runner a goal; it answers at once.

        Args:
            prompt: "": the skill's own. deadline_ticks: 0: none.

        Returns:
            The goal's id; follow it in the runner's feedback.
        """
        request = Goal(
            skill=skill,
            skill_hash=NO_HASH,
            prompt=prompt,
            deadline_ticks=deadline_ticks,
            stall_timeout_s=stall_timeout_s,
        )
        return self._ask(runner, self.keys.goal(runner), request, GoalAccepted).goal_id

    def cancel(self, runner: str, goal_id: int) -> Done:
        """End a runner's goal as soon as possible; how it ended is in its feedback."""
        request = Cancel(goal_id=goal_id, by=self._by)
        return self._ask(runner, self.keys.cancel(runner), request, Done)

    def goal_feedback(self, runner: str) -> GoalFeedback:
        """How a runner's newest goal stands or ended; its id is 0 before the first."""
        return self._ask(runner, self.keys.feedback(runner), StatusQuery(), GoalFeedback)

    def _ask(
        self,
        service: str,
        key: str,
        request: Message,
        kind: type[Reply],
        timeout_s: float = ANSWER_TIMEOUT_S,
    ) -> Reply:
        self.wait_alive(service)
        return decode(kind, self.bus.query(key, request, timeout_s))
