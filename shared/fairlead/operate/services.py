"""Queries to the services of one robot: who is there, what they are doing, do this."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable
from contextlib import suppress
from dataclasses import dataclass

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, NoAnswerError
from fairlead.keys import last_chunk, of_person
from fairlead.messages import (
    Arm,
    ArmReply,
    Cancel,
    Disarm,
    Done,
    GateState,
    GateStatus,
    GoalFeedback,
    HalStatus,
    Message,
    Reset,
    ResetEpisode,
    ResetEpisodeReply,
    StatusQuery,
)
from fairlead.operate.asker import OPERATOR_VARIABLE, asker, person_here
from fairlead.operate.changes import Changes
from fairlead.wire.bus import Bus
from fairlead.wire.on_loop import Reply, ask, call_on

ALIVE_TIMEOUT_S = 3.0
ANSWER_TIMEOUT_S = 3.0  # > LINK_SILENCE_S, else a paused router may arm after "no answer"
GOAL_TIMEOUT_S = 10.0  # a runner compiles the robot's limits before its first goal of a skill
EPISODE_TIMEOUT_S = 60.0  # a simulator builds and settles its scene
GATE_FOLLOWS_TIMEOUT_S = 10.0
LOOK_AGAIN_S = 0.05


@dataclass(frozen=True)
class RobotStatus:
    """What a robot's services say of themselves.

    gate, hal: None where it does not answer. runners: the newest goal of each that answers.
    alive, missing: services of the deployment whose liveliness token is seen, or not.
    """

    gate: GateStatus | None
    hal: HalStatus | None
    runners: tuple[GoalFeedback, ...]
    alive: tuple[str, ...]
    missing: tuple[str, ...]


class Services:
    """The services of one deployment, asked from the event loop that this was made on.

    Attributes:
        deployment: whose services.
        keys: of this robot.
        bus: the transport; its handlers run on threads of their own.
        gate, hal: names of these two services.
        by: person, host and program that ask, for the logs of those who answer.
    """

    def __init__(self, deployment: Deployment, bus: Bus, by: str) -> None:
        self.deployment = deployment
        self.keys = deployment.keys
        self.bus = bus
        self.gate = deployment.only("safety")
        self.hal = deployment.hal
        self.by = asker(deployment, by)
        self._person = person_here(deployment)
        self._loop = asyncio.get_running_loop()
        self._alive: frozenset[str] = frozenset()
        self._gone: Counter[str] = Counter()
        self._changes = Changes()
        self._tokens = bus.watch_tokens(
            self.keys.every_alive,
            lambda key, alive: call_on(self._loop, lambda: self._on_token(last_chunk(key), alive)),
        )

    # --- who is there ---------------------------------------------------------------

    @property
    def alive(self) -> frozenset[str]:
        """Services whose liveliness token is seen now: a hint for people."""
        return self._alive

    def times_gone(self, service: str) -> int:
        """How often a service's token has vanished since this was made."""
        return self._gone[service]

    async def wait_alive(self, *services: str, timeout_s: float = ALIVE_TIMEOUT_S) -> None:
        """Wait until these services are seen.

        Raises:
            NoAnswerError: naming those that are missing.
        """
        wanted = set(services)
        if await self._changes.wait_for(lambda: wanted <= self._alive, timeout_s):
            return
        missing = ", ".join(
            self.deployment.with_host(name) for name in sorted(wanted - self._alive)
        )
        raise NoAnswerError(
            f"robot {self.deployment.id}: {missing} not seen within {timeout_s:g} s; "
            "is it running, or starting again? see: fairlead ps, fairlead logs; "
            "start with: fairlead up DEPLOYMENT"
        )

    async def wait_anyone(self, timeout_s: float = ALIVE_TIMEOUT_S) -> None:
        """Wait until any service is seen.

        Raises:
            NoAnswerError: none is.
        """
        if not await self._changes.wait_for(lambda: bool(self._alive), timeout_s):
            raise NoAnswerError(
                f"robot {self.deployment.id}: no service seen within {timeout_s:g} s; is it "
                "running, started by this user? see: fairlead ps; start with: "
                "fairlead up DEPLOYMENT"
            )

    def _on_token(self, service: str, is_alive: bool) -> None:
        if not is_alive:
            self._gone[service] += 1
        self._alive = self._alive | {service} if is_alive else self._alive - {service}
        self._changes.announce()

    async def status(self, timeout_s: float = ALIVE_TIMEOUT_S) -> RobotStatus:
        """What every service says, and which are missing; nobody's silence is an error.

        Args:
            timeout_s: how long it waits until all are seen.
        """
        services = self.deployment.services
        with suppress(NoAnswerError):
            await self.wait_alive(*services, timeout_s=timeout_s)
        alive = self.alive
        runners = [
            await _unless_silent(self.goal_feedback(name))
            for name in self.deployment.runners
            if name in alive
        ]
        return RobotStatus(
            gate=await _unless_silent(self.gate_status()) if self.gate in alive else None,
            hal=await _unless_silent(self.hal_status()) if self.hal in alive else None,
            runners=tuple(one for one in runners if one is not None),
            alive=tuple(sorted(alive)),
            missing=tuple(sorted(set(services) - alive)),
        )

    # --- the gate -------------------------------------------------------------------

    async def gate_status(self) -> GateStatus:
        """What the gate is doing and why."""
        return await self.ask(self.gate, self.keys.gate_status, StatusQuery(), GateStatus)

    def command(self, key: str) -> str:
        """The key on which this person gives a command.

        Raises:
            ConfigError: the deployment lists people, and no certificate of one is used here.
        """
        people = self.deployment.parties.people
        if people and not self._person:
            raise ConfigError(
                f"deployment {self.deployment.id}: a command needs the certificate of one of "
                f"{', '.join(people)}, and none is here, or several are and {OPERATOR_VARIABLE} "
                "names none (docs/hosts.md)"
            )
        return of_person(key, self._person)

    async def arm(self) -> ArmReply:
        """Let claims be granted. `RefusedError` says what stands in the way."""
        key = self.command(self.keys.gate_command("arm"))
        return await self.ask(self.gate, key, Arm(by=self.by), ArmReply)

    async def disarm(self) -> Done:
        """End every claim; the robot holds."""
        key = self.command(self.keys.gate_command("disarm"))
        return await self.ask(self.gate, key, Disarm(by=self.by), Done)

    async def reset(self, stop_or_latch_id: int) -> Done:
        """Acknowledge one stop or latch; leads to disarmed, never to motion."""
        request = Reset(by=self.by, id=stop_or_latch_id)
        key = self.command(self.keys.gate_command("reset"))
        return await self.ask(self.gate, key, request, Done)

    async def following_gate(self) -> GateStatus | None:
        """The gate's status, if it has left boot and has a state of the HAL that runs now."""
        gate, hal = await self.gate_status(), await self.hal_status()
        follows = gate.session == hal.session and gate.state_tick > 0
        return gate if gate.state != GateState.BOOT and follows else None

    async def wait_gate_follows(self, timeout_s: float = GATE_FOLLOWS_TIMEOUT_S) -> GateStatus:
        """Wait until the gate has left boot and has a state of the HAL that runs now.

        Raises:
            NoAnswerError: saying what it waits for.
        """
        deadline = self._loop.time() + timeout_s
        while (following := await self.following_gate()) is None:
            if self._loop.time() > deadline:
                gate = await self.gate_status()
                raise NoAnswerError(
                    f"robot {self.deployment.id}: the gate does not follow the HAL after "
                    f"{timeout_s:g} s: {gate.cause or GateState(gate.state).name.lower()}"
                )
            await asyncio.sleep(LOOK_AGAIN_S)
        return following

    # --- the HAL and the runners -----------------------------------------------------

    async def hal_status(self) -> HalStatus:
        """Who the robot is, what it has, and how it is paced."""
        return await self.ask(self.hal, self.keys.hal_status, StatusQuery(), HalStatus)

    async def reset_episode(self, seed: int) -> ResetEpisodeReply:
        """Start a new simulated episode; refused unless disarmed."""
        key = self.command(self.keys.hal_command("reset_episode"))
        request = ResetEpisode(seed=seed, by=self.by)
        return await self.ask(self.hal, key, request, ResetEpisodeReply, EPISODE_TIMEOUT_S)

    async def goal_feedback(self, runner: str) -> GoalFeedback:
        """How a runner's newest goal stands or ended; its id is 0 before the first."""
        return await self.ask(runner, self.keys.feedback(runner), StatusQuery(), GoalFeedback)

    async def cancel(self, runner: str, goal_id: int) -> Done:
        """End a runner's goal as soon as possible; how it ended is in its feedback."""
        key, request = self.command(self.keys.cancel(runner)), Cancel(goal_id=goal_id, by=self.by)
        return await self.ask(runner, key, request, Done)

    async def ask(
        self,
        service: str,
        key: str,
        request: Message,
        kind: type[Reply],
        timeout_s: float = ANSWER_TIMEOUT_S,
    ) -> Reply:
        """Send one query to a service that is there, and wait for its reply.

        Raises:
            RefusedError: it said no.
            NoAnswerError: it is not there, or does not answer in time.
        """
        await self.wait_alive(service)
        return await ask(self.bus, key, request, kind, timeout_s)


async def _unless_silent(asking: Awaitable[Reply]) -> Reply | None:
    with suppress(NoAnswerError):
        return await asking
    return None
