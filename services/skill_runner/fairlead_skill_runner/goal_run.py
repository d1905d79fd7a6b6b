"""One goal, start to end: load, claim, run, release. A task of the runner."""

from __future__ import annotations

import asyncio
import logging
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from fairlead.errors import FairleadError
from fairlead.keys import Keys
from fairlead.messages import (
    ClaimReply,
    GateStatus,
    Goal,
    GoalFeedback,
    GoalResult,
    HalStatus,
    Lease,
    StatusQuery,
)
from fairlead.operate.heartbeat import beat
from fairlead.skill.admission import Admission
from fairlead.skill.routes import Route
from fairlead.wire.bus import Bus, Publisher
from fairlead.wire.on_loop import ask
from fairlead_skill_runner import results
from fairlead_skill_runner.claims import (
    QUERY_TIMEOUT_S,
    BeforeClaim,
    claim_request,
    gate_cause,
    live_claims,
    release_claim,
    take_claim,
)
from fairlead_skill_runner.goal_executor import GoalExecutor, Progress, as_feedback
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.trace import TraceWriter


@dataclass(frozen=True)
class Surroundings:
    """What every goal of a runner shares."""

    source: str
    bus: Bus
    keys: Keys
    candidate: Publisher
    heartbeat: Publisher
    trace_file: Path | None
    tasks: asyncio.TaskGroup
    offered: dict[int, asyncio.Task[None]] = field(default_factory=dict)
    """What keeps the claims alive that this runner's next goal may go on with."""
    next_seqs: dict[int, int] = field(default_factory=dict)
    """Of claims that were handed on: above the numbers sent under them, should they come back."""


MOST_HANDED_ON = 16
HAND_OVER_S = 2.0
"""How long a claim is kept alive for the next goal."""


class GoalRun:
    """One goal. Messages go to its `executor`, `feedback` tells how it goes.

    Args:
        gate: what it said of itself when the goal came; None: nothing.
    """

    def __init__(
        self,
        around: Surroundings,
        goal_id: int,
        goal: Goal,
        admission: Admission,
        worker: PolicyWorker,
        gate: GateStatus | None,
    ) -> None:
        self.goal_id = goal_id
        self.skill = admission.skill
        self.result: GoalResult | None = None
        self.executor: GoalExecutor | None = None  # while the goal has a claim, and after
        self._around = around
        self._goal = goal
        self._admission = admission
        self._worker = worker
        self._phase = "loading"
        self._loading: asyncio.Task[None] | None = None
        self._cancelled_by = ""
        self._gate_left: GoalResult | None = None  # without a claim
        self._gate = BeforeClaim(around.bus, around.keys, around.tasks, gate, self._end_unclaimed)
        self._ended = asyncio.Event()
        self._left: dict[int, asyncio.Task[None]] = {}  # to this goal, and not taken by it
        self._log = logging.getLogger(around.source)

    def cancel(self, by: str) -> None:
        """End the goal as soon as possible: a policy that loads is ended at once."""
        self._cancelled_by = self._cancelled_by or by
        self._ended.set()
        if self._loading is not None:
            self._loading.cancel()
        if self.executor is not None:
            self.executor.cancel(by)

    def on_lease(self, lease: Lease) -> None:
        """For a goal that has no claim yet; to be called on the loop."""
        self._gate.on_lease(lease)

    def _end_unclaimed(self, result: GoalResult) -> None:
        """Its policy goes on loading: a gate that was idle for too long is armed again."""
        self._gate_left = result
        self._ended.set()

    def feedback(self) -> GoalFeedback:
        """How the goal stands now."""
        executor = self.executor
        progress = executor.progress() if executor is not None else Progress(self._phase)
        phase = "ended" if self.result else progress.phase
        return as_feedback(
            self._around.source,
            self.goal_id,
            self.skill.id,
            replace(progress, phase=phase),
            self.result,
        )

    async def run(self) -> None:
        """Returns when the goal has a `result`; raises nothing."""
        self._left = self._around.offered.copy()
        self._around.offered.clear()
        try:
            result = await self._run()
        except FairleadError as error:
            by = self._cancelled_by
            result = results.cancelled(by) if by else self._gate_left or results.of_error(error)
        except Exception as error:  # noqa: BLE001 - a bug ends the goal, never the runner
            self._log.exception("goal %016x", self.goal_id)
            result = results.internal_error(error)
        self._gate.over()
        for claim_id in self._leave():
            await self._release(claim_id)
        how = f"{result.outcome} {result.kind}".rstrip()
        self._log.info("goal %016x %s: %s", self.goal_id, how, result.detail)
        self.result = result

    async def _run(self) -> GoalResult:
        around = self._around
        over = await self._loaded()
        if over is not None:
            return over
        token = around.bus.declare_token(around.keys.want_layout(self.skill.id))
        try:
            hal = await ask(
                around.bus, around.keys.hal_status, StatusQuery(), HalStatus, QUERY_TIMEOUT_S
            )
            await asyncio.to_thread(self._admission.require, hal)
            routes = self._admission.routes
            self._phase = "claiming"
            request = claim_request(
                around.source, self.skill, routes, self._admission.robot, self._goal.by
            )
            before = await live_claims(around.bus, around.keys)
            claim = await take_claim(around.bus, around.keys, request, hal.pacing, self._ended)
            return await self._run_claimed(hal, routes, claim, claim.claim_id in before)
        finally:
            token.undeclare()

    async def _loaded(self) -> GoalResult | None:
        """Load the policy; how the goal has ended meanwhile, if it has."""
        self._loading = asyncio.create_task(self._load())
        if self._cancelled_by:
            self._loading.cancel()
        ended = asyncio.create_task(self._ended.wait())
        try:
            await asyncio.wait({self._loading, ended}, return_when=asyncio.FIRST_COMPLETED)
            if self._gate_left is not None and not self._cancelled_by:
                self._loading.add_done_callback(self._log_load)
                return self._gate_left
            await self._loading
        except asyncio.CancelledError:
            if not self._cancelled_by:  # the runner ends
                self._loading.cancel()
                raise
        finally:
            ended.cancel()
        return results.cancelled(self._cancelled_by) if self._cancelled_by else None

    async def _load(self) -> None:
        await self._worker.load()
        if self._gate_left is None:
            await self._worker.reset()

    def _log_load(self, loading: asyncio.Task[None]) -> None:
        error = None if loading.cancelled() else loading.exception()
        if error is not None:
            self._log.warning("skill %s is not loaded: %s", self.skill.id, error)

    async def _run_claimed(
        self, hal: HalStatus, routes: tuple[Route, ...], claim: ClaimReply, handed_over: bool
    ) -> GoalResult:
        around = self._around
        beating = around.tasks.create_task(beat(around.heartbeat, claim.claim_id), name="heartbeat")
        self._log.info("goal %016x has claim %016x", self.goal_id, claim.claim_id)
        self._leave()  # what it has not taken ends without heartbeats
        self._gate.over()
        lost, offered_to = False, ""
        trace = TraceWriter(around.trace_file) if around.trace_file is not None else None
        try:
            left = self._gate_left or self._gate.refusal(claim)
            if left is not None:
                return left
            if claim.session != hal.session:
                return results.new_session(hal.session, claim.session)
            setup = RunSetup.of(
                around.source,
                self.goal_id,
                self._goal,
                self.skill,
                routes,
                hal,
                claim,
                self._admission.robot,
                handed_over,
                around.next_seqs.pop(claim.claim_id, 1),
            )
            result = await self._follow(setup, trace)
            lost = result.kind == "claim_lost"
            if result.outcome == "succeeded":
                offered_to = self._goal.hand_over_to
            return await self._with_cause(result) if lost else result
        finally:
            if offered_to:
                self._hand_on(claim.claim_id, offered_to, beating)
            else:
                beating.cancel()
            if not lost:
                await self._release(claim.claim_id, offered_to)
            if trace is not None:
                await asyncio.to_thread(trace.close)

    def _hand_on(self, claim_id: int, offered_to: str, beating: asyncio.Task[None]) -> None:
        """Keep the claim alive for whom it is offered to, and the count for when it comes back."""
        around = self._around
        if self.executor is not None:
            around.next_seqs[claim_id] = self.executor.next_seq
        for old in list(around.next_seqs)[:-MOST_HANDED_ON]:
            del around.next_seqs[old]
        if offered_to == around.source:
            around.offered[claim_id] = beating
        asyncio.get_running_loop().call_later(HAND_OVER_S, beating.cancel)

    def _leave(self) -> tuple[int, ...]:
        """Beat no more for what was offered to this goal; returns these claims."""
        claims = tuple(self._left)
        for beating in self._left.values():
            beating.cancel()
        self._left.clear()
        return claims

    async def _release(self, claim_id: int, offered_to: str = "") -> None:
        around = self._around
        problem = await release_claim(around.bus, around.keys, around.source, claim_id, offered_to)
        if problem:
            self._log.warning("claim %016x not released: %s", claim_id, problem)

    async def _with_cause(self, result: GoalResult) -> GoalResult:
        """A lost claim needs no release; the gate says why it is gone."""
        cause = await gate_cause(self._around.bus, self._around.keys)
        detail = result.detail + (f" ({cause})" if cause else "")
        return msgspec.structs.replace(result, detail=detail)

    async def _follow(self, setup: RunSetup, trace: TraceWriter | None) -> GoalResult:
        around = self._around
        self.executor = GoalExecutor(setup, self._worker, around.candidate, trace, around.tasks)
        if self._cancelled_by:
            self.executor.cancel(self._cancelled_by)
        return await self.executor.follow()
