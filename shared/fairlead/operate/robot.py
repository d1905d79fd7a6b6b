"""A running robot, for programs on an event loop: the whole of what `fairlead.connect` gives."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine, Iterable, Sequence
from functools import cached_property
from typing import Any, TypeVar, cast
from weakref import WeakSet

from fairlead.deploy.deployment import Deployment
from fairlead.errors import TransportError
from fairlead.keys import check_name
from fairlead.messages import (
    NO_HASH,
    Done,
    GateStatus,
    Goal,
    JointState,
    Load,
    Message,
    TransformBatch,
    Verdict,
    decode,
)
from fairlead.operate.asker import own_endpoints
from fairlead.operate.changes import unbroken
from fairlead.operate.claim_request import claim_request
from fairlead.operate.goal import RunningGoal
from fairlead.operate.part_claim import PartClaim
from fairlead.operate.protective_stop import NO_REASON, request_stop
from fairlead.operate.runner_choice import choose_runner
from fairlead.operate.services import GOAL_TIMEOUT_S, Services
from fairlead.operate.subscription import QUEUE, SILENCE_S, Heard, Subscription
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.wire.bus import Bus, Sample
from fairlead.wire.on_loop import open_session
from fairlead.wire.topics import EVERY, find_topic, short_key

STALL_TIMEOUT_S = 30.0
CLOSED = "this client is closed; connect anew"

T = TypeVar("T")
M = TypeVar("M", bound=Message)


class Robot(Services):
    """One running robot: ask its services, give it goals, hold parts of it, look on.

    Its methods are to be called on the event loop it was opened on. What it began ends with it:
    `close` ends goals that have not ended, gives back claims and ends its subscriptions. After it
    what is asked of anybody is a `TransportError`.
    """

    def __init__(self, deployment: Deployment, bus: Bus, by: str) -> None:
        super().__init__(deployment, bus, by)
        self._goals: list[RunningGoal] = []
        self._claims: WeakSet[PartClaim] = WeakSet()
        self._subscriptions: WeakSet[Subscription[object]] = WeakSet()
        self._owns_bus = False
        self._closed: asyncio.Future[None] | None = None

    @classmethod
    async def open(cls, deployment: Deployment, by: str, bus: Bus | None = None) -> Robot:
        """Join a robot's services; ``bus`` None opens a Zenoh session, which `close` closes.

        Raises:
            ConfigError: FAIRLEAD_OPERATOR names nobody who could be meant here; no certificate.
            TransportError: if the session cannot be opened.
        """
        opened = bus if bus is not None else await open_session(own_endpoints(deployment))
        robot = cls(deployment, opened, by)
        robot._owns_bus = bus is None
        return robot

    async def close(self) -> None:
        """End what was begun here, then the session; the services are left as they are."""
        if self._closed is not None:
            return await asyncio.shield(self._closed)
        self._closed = asyncio.get_running_loop().create_future()
        try:
            await self._close()
        finally:
            self._closed.set_result(None)

    async def _close(self) -> None:
        try:
            await _all_of(_leave(goal) for goal in self._goals if not goal.is_over)
        finally:
            try:
                await unbroken(_all_of(claim.release() for claim in self._claims))
            finally:
                for subscription in list(self._subscriptions):
                    subscription.close()
                self._tokens.undeclare()
                bus, self.bus = self.bus, cast("Bus", _Closed())
                if self._owns_bus:
                    await asyncio.to_thread(bus.close)

    @cached_property
    def manifest(self) -> RobotManifest:
        """The robot's manifest, as this machine has it."""
        return load_robot(self.deployment.robot)

    # --- to move it, and to stop it -----------------------------------------------------

    async def stop(self, reason: str = NO_REASON) -> int:
        """Request a protective stop, repeated until a lease lists it.

        Args:
            reason: for the log.

        Returns:
            The stop's id, which a reset must cite.

        Raises:
            NoAnswerError: no lease listed it in time; the robot may still move.
        """
        return await request_stop(self, reason)

    async def run(
        self,
        skill: str,
        *,
        prompt: str = "",
        deadline_ticks: int = 0,
        stall_timeout_s: float = STALL_TIMEOUT_S,
        runner: str = "",
        hand_over_to: str = "",
    ) -> RunningGoal:
        """Hand a runner a goal; the gate has to be armed.

        Args:
            prompt: "": the skill's own.
            deadline_ticks: 0: none.
            stall_timeout_s: it fails after so long without a released row.
            runner: a service's name; "": the only one for the skill.
            hand_over_to: a runner: once this goal has succeeded, that one's next goal goes on
                without a hold if it commands the same parts and comes within 2 s; "": none.

        Raises:
            ConfigError: no runner, or none that is clear, for the skill; none to hand over to.
            RefusedError: the runner did not take the goal.
        """
        if hand_over_to:
            choose_runner(self.deployment, skill, hand_over_to)
        request = Goal(
            skill=skill,
            skill_hash=NO_HASH,
            prompt=prompt,
            deadline_ticks=deadline_ticks,
            stall_timeout_s=stall_timeout_s,
            hand_over_to=hand_over_to,
            by=self.by,
        )
        goal = RunningGoal(self, choose_runner(self.deployment, skill, runner), skill)
        self._goals = [one for one in self._goals if not one.is_over] + [goal]
        await goal.start(request)
        return goal

    async def load(self, skill: str, runner: str = "") -> Done:
        """Have a runner load a skill's policy, while a goal runs too; `messages.Load` has replies.

        Args:
            runner: a service's name; "": the only one for the skill.

        Raises:
            ConfigError: no runner, or none that is clear, for the skill.
            RefusedError: the runner does not offer the skill, or cannot load its policy.
        """
        chosen = choose_runner(self.deployment, skill, runner)
        key, request = self.command(self.keys.load(chosen)), Load(skill=skill, by=self.by)
        return await self.ask(chosen, key, request, Done, GOAL_TIMEOUT_S)

    def claim(self, parts: Sequence[str], *, source: str, task: str = "") -> PartClaim:
        """Parts to hold in an ``async with`` block, and to command through the gate.

        The gate has to be armed. Another source's claims are not touched. With an arm goes its
        composite switch.

        Args:
            source: a name of one's own, not that of a runner: it stands in keys and verdicts.
            task: what for, as ``fairlead status`` shows it; "": ``source``.

        Raises:
            ConfigError: the robot has no such part, or the source is no name of one's own.
        """
        request = claim_request(self.manifest, self.deployment, parts, source, task, self.by)
        claim = PartClaim(self, self.manifest, request)
        self._claims.add(claim)
        return claim

    # --- to look on ---------------------------------------------------------------------

    def joint_states(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> Subscription[JointState]:
        """What the HAL measures, every tick; a lockstep world that waits repeats its tick."""
        return self._messages(self.keys.joints, JointState, queue, timeout_s)

    def transforms(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> Subscription[TransformBatch]:
        """Transforms of every publisher: the HAL, the assembler, a localiser."""
        return self._messages(self.keys.every_tf, TransformBatch, queue, timeout_s)

    def verdicts(
        self, source: str = EVERY, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> Subscription[Verdict]:
        """The gate's answers to one source's chunks, or to everybody's."""
        if source != EVERY:
            check_name("source", source)
        return self._messages(self.keys.verdict(source), Verdict, queue, timeout_s)

    def gate_statuses(
        self, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> Subscription[GateStatus]:
        """What the gate is doing, whenever that changes and twice a second."""
        return self._messages(self.keys.gate_status, GateStatus, queue, timeout_s)

    def topic(
        self, name: str, queue: int = QUEUE, timeout_s: float = SILENCE_S
    ) -> Subscription[Heard]:
        """Whatever a key or a family of keys carries: a name as in ``fairlead topic list``.

        Raises:
            ConfigError: listing the keys there are.
        """
        topic = find_topic(self.keys, str(name))

        def read(sample: Sample) -> Heard:
            return Heard(sample.key, decode(topic.kind, sample.payload), time.monotonic())

        return self._subscribe(name, topic.key_expr, read, queue, timeout_s)

    def _messages(
        self, key_expr: str, kind: type[M], queue: int, timeout_s: float
    ) -> Subscription[M]:
        name = short_key(self.keys, key_expr)
        return self._subscribe(
            name, key_expr, lambda sample: decode(kind, sample.payload), queue, timeout_s
        )

    def _subscribe(
        self,
        name: str,
        key_expr: str,
        read: Callable[[Sample], T],
        queue: int,
        timeout_s: float,
    ) -> Subscription[T]:
        made = Subscription(self.bus, name, key_expr, read, queue, timeout_s)
        self._subscriptions.add(made)  # type: ignore[arg-type]
        return made


class _Closed:
    """The transport of a robot whose session has ended."""

    def __getattr__(self, name: str) -> Any:
        raise TransportError(CLOSED)


async def _all_of(doing: Iterable[Coroutine[None, None, None]]) -> None:
    for error in filter(None, await asyncio.gather(*doing, return_exceptions=True)):
        raise error


async def _leave(goal: RunningGoal) -> None:
    try:
        await goal.leave()
    finally:
        goal.log_stopped()
