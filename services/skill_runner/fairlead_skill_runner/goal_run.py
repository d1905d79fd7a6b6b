"""One goal, start to end: load, claim, run, release. Runs on a thread of its own."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from fairlead.admission import require_admission
from fairlead.bus import Bus, Publisher
from fairlead.errors import ConfigError, FairleadError, PolicyError
from fairlead.keys import Keys
from fairlead.messages import (
    ClaimReply,
    Goal,
    GoalFeedback,
    GoalResult,
    HalStatus,
    StatusQuery,
    decode,
)
from fairlead.robot import RobotManifest
from fairlead.routes import Route, resolve_routes
from fairlead.skill import SkillManifest
from fairlead_skill_runner import results
from fairlead_skill_runner.claims import (
    QUERY_TIMEOUT_S,
    claim_request,
    gate_cause,
    release_claim,
    take_claim,
)
from fairlead_skill_runner.heartbeat import HeartbeatThread
from fairlead_skill_runner.inference import InferenceThread
from fairlead_skill_runner.policies.protocol import Actions
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_core import AskPolicy, Output, RunCore, SendChunk
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.trace import TraceRecord, TraceWriter

_CHECK_S = 0.05


@dataclass(frozen=True)
class Surroundings:
    """What every goal of a runner shares."""

    source: str
    bus: Bus
    keys: Keys
    robot: RobotManifest
    candidate: Publisher
    heartbeat: HeartbeatThread
    trace_file: Path | None


class GoalRun:
    """One goal. `deliver` brings messages in, `feedback` tells how it goes."""

    def __init__(
        self,
        around: Surroundings,
        goal_id: int,
        goal: Goal,
        skill: SkillManifest,
        worker: PolicyWorker,
    ) -> None:
        self.goal_id = goal_id
        self.skill = skill
        self.result: GoalResult | None = None
        self._around = around
        self._goal = goal
        self._worker = worker
        self._phase = "loading"
        self._lock = threading.RLock()
        self._core: RunCore | None = None
        self._inference: InferenceThread | None = None
        self._trace: TraceWriter | None = None
        self._cancelled_by = ""
        self._ended = threading.Event()
        self._log = logging.getLogger(around.source)

    def deliver(self, handle: Callable[[RunCore, float], Sequence[Output]]) -> None:
        """Let the core handle one message, and do what it says. Ignored outside the run."""
        with self._lock:
            core = self._core
            if core is None or core.is_over():
                return
            self._execute(handle(core, time.monotonic()))
            if core.is_over():
                self._ended.set()

    def cancel(self, by: str) -> None:
        """End the goal as soon as possible."""
        with self._lock:
            self._cancelled_by = self._cancelled_by or by
            if self._core is not None:
                self._core.cancel(by)
            self._ended.set()

    def feedback(self) -> GoalFeedback:
        """How the goal stands now."""
        with self._lock:
            core = self._core
            return GoalFeedback(
                source=self._around.source,
                goal_id=self.goal_id,
                skill=self.skill.id,
                phase="ended" if self.result else core.phase if core else self._phase,
                tick=core.tick if core else 0,
                queue_depth=core.queue_depth if core else 0,
                inferences=core.inferences if core else 0,
                starved=core.starved if core else 0,
                last_refusal=core.last_refusal if core else "",
                result=self.result,
            )

    def run(self) -> GoalResult:
        """Blocks until the goal has ended; never raises."""
        try:
            result = self._run()
        except FairleadError as error:
            by = self._cancelled_by
            result = results.cancelled(by) if by else results.of_error(error)
        except Exception as error:  # noqa: BLE001 - a bug ends the goal, never the runner
            self._log.exception("goal %016x", self.goal_id)
            result = results.internal_error(error)
        self._log.info(
            "goal %016x %s %s: %s", self.goal_id, result.outcome, result.kind, result.detail
        )
        with self._lock:
            self.result = result
        return result

    def _run(self) -> GoalResult:
        around = self._around
        self._worker.load()
        self._worker.reset()
        if self._cancelled_by:
            return results.cancelled(self._cancelled_by)
        token = around.bus.declare_token(around.keys.want_layout(self.skill.id))
        try:
            hal = decode(
                HalStatus, around.bus.query(around.keys.hal_status, StatusQuery(), QUERY_TIMEOUT_S)
            )
            require_admission(self.skill, around.robot, hal)
            routes = resolve_routes(self.skill.action_contract, around.robot)
            self._phase = "claiming"
            request = claim_request(around.source, self.skill, routes, around.robot.robot_hash)
            claim = take_claim(around.bus, around.keys, request, hal.pacing, self._ended)
            return self._run_claimed(hal, routes, claim)
        finally:
            token.undeclare()

    def _run_claimed(
        self, hal: HalStatus, routes: tuple[Route, ...], claim: ClaimReply
    ) -> GoalResult:
        around = self._around
        around.heartbeat.keep(claim.claim_id)
        self._log.info("goal %016x has claim %016x", self.goal_id, claim.claim_id)
        lost = False
        try:
            if claim.session != hal.session:
                return results.new_session(hal.session, claim.session)
            setup = RunSetup.of(
                around.source, self.goal_id, self._goal, self.skill, routes, hal, claim
            )
            result = self._follow(setup)
            lost = result.kind == "claim_lost"
            return self._with_cause(result) if lost else result
        finally:
            around.heartbeat.keep(0)
            problem = "" if lost else self._release(claim)
            if problem:
                self._log.warning("claim %016x not released: %s", claim.claim_id, problem)

    def _release(self, claim: ClaimReply) -> str:
        around = self._around
        return release_claim(around.bus, around.keys, around.source, claim.claim_id)

    def _with_cause(self, result: GoalResult) -> GoalResult:
        """A lost claim needs no release; the gate says why it is gone."""
        cause = gate_cause(self._around.bus, self._around.keys)
        detail = result.detail + (f" ({cause})" if cause else "")
        return msgspec.structs.replace(result, detail=detail)

    def _follow(self, setup: RunSetup) -> GoalResult:
        if self._around.trace_file is not None:
            self._trace = TraceWriter(self._around.trace_file)
        self._inference = InferenceThread(self._worker, self._on_answer)
        core = RunCore(setup, time.monotonic())
        with self._lock:
            self._core = core
            if self._cancelled_by:
                core.cancel(self._cancelled_by)
        while core.result is None:
            self._ended.wait(_CHECK_S)
            self.deliver(lambda running, now_s: running.on_time(now_s))
        threading.Thread(target=self._close_inference, daemon=True).start()
        return core.result

    def _close_inference(self) -> None:
        """A policy call may still be running; the claim is not kept waiting for it."""
        assert self._inference is not None
        self._inference.close()
        if self._trace is not None:
            self._trace.close()

    def _on_answer(self, question: AskPolicy, answer: Actions | PolicyError) -> None:
        with self._lock:
            core = self._core
            if core is not None and core.result is None:
                self._record(question, answer)
            self.deliver(lambda running, now_s: running.on_policy(question.call, answer, now_s))

    def _record(self, question: AskPolicy, answer: Actions | PolicyError) -> None:
        if self._trace is not None and not isinstance(answer, PolicyError):
            seen = question.observation
            self._trace.write(TraceRecord(tick=seen.tick, state=seen.state, actions=answer))

    def _execute(self, outputs: Sequence[Output]) -> None:
        for output in outputs:
            if isinstance(output, SendChunk):
                self._around.candidate.put_bytes(output.payload)
            elif self._inference is not None:
                self._inference.ask(output)


def check_goal(goal: Goal, skill: SkillManifest) -> None:
    """Raise `ConfigError` for a goal whose numbers cannot be meant."""
    if not 0.0 < goal.stall_timeout_s < float("inf"):
        raise ConfigError(
            f"goal: stall_timeout_s: expected more than 0 s, got {goal.stall_timeout_s:g}"
        )
    if goal.skill_hash not in (bytes(32), skill.skill_hash):
        raise ConfigError(
            f"goal: skill {skill.id}: expected the manifest {skill.skill_hash.hex()[:16]} this "
            f"runner has loaded, got {goal.skill_hash.hex()[:16]}"
        )
