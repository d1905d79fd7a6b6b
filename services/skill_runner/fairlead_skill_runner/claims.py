"""Taking a claim from the gate and giving it back; after a stop nothing begins."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from contextlib import suppress

from fairlead.errors import FairleadError, RefusedError
from fairlead.keys import Keys
from fairlead.messages import (
    Claim,
    ClaimReply,
    Done,
    GateState,
    GateStatus,
    GoalResult,
    Lease,
    LimitOverride,
    Release,
    StatusQuery,
)
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import Route
from fairlead.wire.bus import Bus
from fairlead.wire.on_loop import ask
from fairlead.wire.verdict_text import why_not_armed
from fairlead_skill_runner import results

QUERY_TIMEOUT_S = 2.0
_RETRY_S = 0.1
# The gate's heartbeat timeout, with a margin for its own period.
_FORMER_CLAIM_S = {"realtime": 0.5, "lockstep": 2.5}


def claim_request(
    source: str, skill: SkillManifest, routes: tuple[Route, ...], robot: RobotManifest, by: str
) -> Claim:
    """What a skill asks of the gate; the gate checks hashes and period once, here."""
    return Claim(
        source=source,
        skill=skill.id,
        skill_hash=skill.skill_hash,
        robot_hash=robot.robot_hash,
        period_ns=robot.tick_period_ns,
        parts=robot.claimed_parts([route.part_name for route in routes]),
        chunk_rate_hz=1e9 / robot.tick_period_ns,  # at most one chunk per control period
        horizon_max=skill.horizon * (skill.control_periods(robot.tick_period_ns) or 1),
        age_max_ticks=skill.age_max_ticks,
        limits=tuple(
            LimitOverride(part=limit.part, mode=int(limit.mode), name=limit.name, value=limit.value)
            for limit in skill.limits
        ),
        by=by,
    )


async def take_claim(
    bus: Bus, keys: Keys, request: Claim, pacing: str, ended: asyncio.Event
) -> ClaimReply:
    """Ask for the claim; wait one heartbeat window where our own former claim is in the way.

    A runner that was killed leaves a claim behind that lives until its heartbeat is missed.

    Args:
        ended: set when the goal is over; a query that is under way is waited for.

    Raises:
        RefusedError: with the gate's reason and the command that would change it.
        NoAnswerError: if no gate answers.
    """
    key = keys.claim(request.source)
    until_s = time.monotonic() + _FORMER_CLAIM_S[pacing]
    while True:
        try:
            return await ask(bus, key, request, ClaimReply, QUERY_TIMEOUT_S)
        except RefusedError:
            if time.monotonic() > until_s:
                raise
            if request.source not in (await live_claims(bus, keys)).values():
                raise
        with suppress(TimeoutError):
            async with asyncio.timeout(_RETRY_S):
                await ended.wait()
                raise RefusedError(
                    request.source, "the goal was ended while it waited for its claim"
                )


async def release_claim(
    bus: Bus, keys: Keys, source: str, claim_id: int, offered_to: str = ""
) -> str:
    """Give the claim back, or offer it; returns why that failed, "" if it did not."""
    try:
        request = Release(source=source, claim_id=claim_id, offered_to=offered_to)
        await ask(bus, keys.release(source), request, Done, QUERY_TIMEOUT_S)
    except FairleadError as error:
        return str(error)
    return ""


async def gate_cause(bus: Bus, keys: Keys) -> str:
    """Why the gate is not armed and what would change it; "" if it is, or does not answer."""
    status = await gate_status(bus, keys)
    return "" if status is None else why_not_armed(status)


async def live_claims(bus: Bus, keys: Keys) -> dict[int, str]:
    """The sources of the claims that the gate knows, by id; none if it does not answer.

    A claim that is granted under one of these ids goes on with that one's rows.
    """
    status = await gate_status(bus, keys)
    return {} if status is None else {claim.claim_id: claim.source for claim in status.claims}


async def gate_status(bus: Bus, keys: Keys) -> GateStatus | None:
    """What the gate says of itself; None if it does not answer."""
    try:
        return await ask(bus, keys.gate_status, StatusQuery(), GateStatus, QUERY_TIMEOUT_S)
    except FairleadError:
        return None


class BeforeClaim:
    """A goal takes its claim only if the gate has stayed as it was when the goal came.

    Each arming begins another epoch, and only an armed gate grants claims: one of the same epoch
    says that there was no stop, latch or disarm. Leases say so earlier. They can be late, so
    what they say is asked of the gate itself.

    Args:
        gate: its answer when the goal came; None: none, and no claim is taken.
        end: called on the loop, with how the goal ends.
    """

    def __init__(
        self,
        bus: Bus,
        keys: Keys,
        tasks: asyncio.TaskGroup,
        gate: GateStatus | None,
        end: Callable[[GoalResult], None],
    ) -> None:
        self._bus, self._keys, self._tasks = bus, keys, tasks
        self._gate, self._end = gate, end
        self._asking = self._is_over = False

    def on_lease(self, lease: Lease) -> None:
        """Ask the gate if the lease is another one's than it was."""
        if self._has_left(lease) and not (self._asking or self._is_over):
            self._asking = True
            self._tasks.create_task(self._ask(), name="gate of a goal without a claim")

    def over(self) -> None:
        """The goal has its claim, or has ended: ask no more."""
        self._is_over = True

    def refusal(self, claim: ClaimReply) -> GoalResult | None:
        """How the goal ends, if it must not use this claim."""
        same = self._gate is not None and claim.epoch == self._gate.epoch
        return None if same else results.gate_left(self._what())

    async def _ask(self) -> None:
        now = await gate_status(self._bus, self._keys)
        self._asking = False  # without an answer the next lease asks again
        if now is not None and self._has_left(now) and not self._is_over:
            self._end(results.gate_left(self._what(), why_not_armed(now)))

    def _has_left(self, now: Lease | GateStatus) -> bool:
        if self._gate is None or now.epoch != self._gate.epoch:
            return True
        return self._gate.state == GateState.ARMED and now.state != GateState.ARMED

    def _what(self) -> str:
        if self._gate is None:
            return "the gate did not answer when the goal came"
        if self._gate.state == GateState.ARMED:
            return "the gate has not stayed armed since the goal came"
        return "the gate was not armed when the goal came"
