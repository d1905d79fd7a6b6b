"""One goal, start to end: load, claim, run, release. Runs on a thread of its own."""

from __future__ import annotations

import logging
import threading
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from fairlead.errors import FairleadError
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
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import require_admission
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import Route, resolve_routes
from fairlead.wire.bus import Bus, Publisher
from fairlead_skill_runner import results
from fairlead_skill_runner.claims import (
    QUERY_TIMEOUT_S,
    claim_request,
    gate_cause,
    release_claim,
    take_claim,
)
from fairlead_skill_runner.core_drive import CoreDrive, Handle, Progress
from fairlead_skill_runner.heartbeat import HeartbeatThread
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.trace import TraceWriter


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
        self._lock = threading.Lock()
        self._drive: CoreDrive | None = None
        self._cancelled_by = ""
        self._ended = threading.Event()
        self._log = logging.getLogger(around.source)

    def deliver(self, handle: Handle) -> None:
        """Let the core handle one message, and do what it says. Ignored outside the run."""
        drive = self._drive
        if drive is not None:
            drive.deliver(handle)

    def cancel(self, by: str) -> None:
        """End the goal as soon as possible."""
        with self._lock:
            self._cancelled_by = self._cancelled_by or by
            drive = self._drive
        self._ended.set()
        if drive is not None:
            drive.cancel(by)

    def feedback(self) -> GoalFeedback:
        """How the goal stands now."""
        result, drive = self.result, self._drive
        progress = drive.progress() if drive is not None else Progress(self._phase)
        phase = "ended" if result else progress.phase
        return _feedback(
            self._around.source, self.goal_id, self.skill.id, replace(progress, phase=phase), result
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
        how = f"{result.outcome} {result.kind}".rstrip()
        self._log.info("goal %016x %s: %s", self.goal_id, how, result.detail)
        self.result = result
        return result

    def _run(self) -> GoalResult:
        around = self._around
        self._worker.load(self._ended)
        self._worker.reset(self._ended)
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
            request = claim_request(around.source, self.skill, routes, around.robot)
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
        trace = TraceWriter(around.trace_file) if around.trace_file is not None else None
        try:
            if claim.session != hal.session:
                return results.new_session(hal.session, claim.session)
            setup = RunSetup.of(
                around.source, self.goal_id, self._goal, self.skill, routes, hal, claim
            )
            result = self._follow(setup, trace)
            lost = result.kind == "claim_lost"
            return self._with_cause(result) if lost else result
        finally:
            around.heartbeat.keep(0)
            problem = "" if lost else self._release(claim)
            if problem:
                self._log.warning("claim %016x not released: %s", claim.claim_id, problem)
            if trace is not None:
                trace.close()

    def _release(self, claim: ClaimReply) -> str:
        around = self._around
        return release_claim(around.bus, around.keys, around.source, claim.claim_id)

    def _with_cause(self, result: GoalResult) -> GoalResult:
        """A lost claim needs no release; the gate says why it is gone."""
        cause = gate_cause(self._around.bus, self._around.keys)
        detail = result.detail + (f" ({cause})" if cause else "")
        return msgspec.structs.replace(result, detail=detail)

    def _follow(self, setup: RunSetup, trace: TraceWriter | None) -> GoalResult:
        around = self._around
        drive = CoreDrive(setup, self._worker, around.candidate, trace)
        with self._lock:
            self._drive = drive
            cancelled_by = self._cancelled_by
        if cancelled_by:
            drive.cancel(cancelled_by)
        return drive.follow()


def no_goal(source: str) -> GoalFeedback:
    """What a runner says of its goal before the first."""
    return _feedback(source, 0, "", Progress("idle"), None)


def _feedback(
    source: str, goal_id: int, skill: str, progress: Progress, result: GoalResult | None
) -> GoalFeedback:
    return GoalFeedback(
        source=source,
        goal_id=goal_id,
        skill=skill,
        phase=progress.phase,
        tick=progress.tick,
        queue_depth=progress.queue_depth,
        inferences=progress.inferences,
        starved=progress.starved,
        last_refusal=progress.last_refusal,
        result=result,
    )
