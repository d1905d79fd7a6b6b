"""The runner on its bus: goals in, messages to the goal that runs, feedback out."""

from __future__ import annotations

import asyncio
import logging
import secrets
from pathlib import Path

from fairlead.errors import ConfigError, FairleadError, RefusedError
from fairlead.jpeg import decoded
from fairlead.messages import (
    BEING_LOADED,
    NO_HASH,
    ActionChunk,
    Cancel,
    Done,
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    HalStatus,
    Heartbeat,
    Image,
    JointState,
    LayoutState,
    Lease,
    Load,
    Message,
    StatusQuery,
    StopLevel,
    TaskState,
    Verdict,
    decode,
)
from fairlead.service import ServiceContext
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.on_loop import call_on
from fairlead_skill_runner.claims import gate_status
from fairlead_skill_runner.goal_executor import no_goal
from fairlead_skill_runner.goal_run import GoalRun, Surroundings
from fairlead_skill_runner.offered_skills import OfferedSkills
from fairlead_skill_runner.policy_worker import PolicyWorker

FEEDBACK_S = 0.5
_CHANGE_CHECK_S = 0.05
_ANSWER_S = 2.5  # < ANSWER_TIMEOUT_S of the client
_GOAL_ANSWER_S = 9.0  # < GOAL_TIMEOUT_S of the client, which ends a goal it no longer wants
_LOAD_ANSWER_S = 1.0  # until then whoever asked for it is told how loading ended


class SkillRunner:
    """Runs one goal at a time, on the event loop that it was made on.

    Messages go from the transport's threads straight to the goal's executor; all else is a task.

    Args:
        trace_file: where each goal writes what its policy saw and said; None: nowhere.
    """

    def __init__(
        self,
        context: ServiceContext,
        skills: OfferedSkills,
        trace_file: Path | None = None,
    ) -> None:
        self._bus, self._keys, self._source = context.bus, context.deployment.keys, context.name
        self._skills, self._tasks = skills, context.tasks
        self._log = logging.getLogger(self._source)
        self._heard: set[str] = set()
        self._hal: HalStatus | None = None
        self._goal: GoalRun | None = None
        self._goal_task: asyncio.Task[None] | None = None
        self._loads: dict[str, asyncio.Task[str]] = {}
        self._published: tuple[int, str, str, GoalResult | None] | None = None
        self._quiet_s = 0.0
        self._accepting = asyncio.Lock()
        self._loop, self._stops = asyncio.get_running_loop(), 0
        keys, source = self._keys, self._source
        self._feedback = self._bus.publisher(keys.feedback(source), GoalFeedback, Qos.STATUS)
        self._around = Surroundings(
            source=source,
            bus=self._bus,
            keys=keys,
            candidate=self._bus.publisher(keys.candidate(source), ActionChunk, Qos.HOT),
            heartbeat=self._bus.publisher(keys.heartbeat(source), Heartbeat, Qos.HOT),
            trace_file=trace_file,
            tasks=context.tasks,
        )
        self._subscribe_all()
        people, serve = context.deployment.parties.people, context.queries.serve_command
        serve(keys.goal(source), Goal, self._on_goal, _GOAL_ANSWER_S, people)
        serve(keys.cancel(source), Cancel, self._on_cancel, _ANSWER_S, people)
        serve(keys.load(source), Load, self._on_load, _GOAL_ANSWER_S, people)
        context.queries.serve(keys.feedback(source), self._on_status, _ANSWER_S)
        self._tasks.create_task(self._publish_feedback(), name="feedback")

    async def close(self) -> None:
        """End the goal that runs, give its claim back, end the policies."""
        if self._goal is not None and self._goal_task is not None:
            self._goal.cancel("the runner, which is shutting down")
            await asyncio.wait({self._goal_task})
        await self._skills.close()

    # --- messages ------------------------------------------------------------------

    def _subscribe_all(self) -> None:
        keys = self._keys
        self._forward(keys.joints, JointState)
        self._forward(keys.task, TaskState)
        self._forward(keys.verdict(self._source), Verdict)
        self._bus.subscribe(keys.hal_status, self._on_hal_status)
        self._bus.subscribe(keys.stop, self._on_stop)
        self._bus.subscribe(keys.lease, self._on_lease)
        for skill in self._skills.at_start().values():
            self._hear(skill)

    def _hear(self, skill: SkillManifest) -> None:
        """Subscribe to the layout and the cameras of a skill, each key once."""
        keys = self._keys
        layout, cameras = keys.layout(skill.id), {image.camera for image in skill.images.values()}
        for key in {layout, *map(keys.camera, cameras)} - self._heard:
            self._heard.add(key)
            self._forward(key, LayoutState if key == layout else Image)

    def _forward(self, key: str, kind: type[Message]) -> None:
        """Have every message of a key go to the goal that runs, on the thread that brings it."""

        def on_sample(sample: Sample) -> None:
            executor = self._goal.executor if self._goal is not None else None
            if executor is not None and not executor.is_over:
                message = decode(kind, sample.payload)
                # Here what is no JPEG is dropped and said; in the goal it would end the goal.
                executor.deliver(decoded(message) if isinstance(message, Image) else message)

        if kind is Image:
            self._bus.subscribe_frames(key, on_sample)
        else:
            self._bus.subscribe(key, on_sample)

    def _on_hal_status(self, sample: Sample) -> None:
        self._hal = status = decode(HalStatus, sample.payload)
        executor = self._goal.executor if self._goal is not None else None
        if executor is not None:
            executor.deliver(status)

    def _on_stop(self, sample: Sample) -> None:
        stop = decode(StopLevel, sample.payload)
        call_on(self._loop, lambda: self._end_before_claim(stop))

    def _on_lease(self, sample: Sample) -> None:
        goal = self._goal
        if goal is None or goal.result is not None:
            return
        executor = goal.executor
        if executor is None:
            lease = decode(Lease, sample.payload)
            call_on(self._loop, lambda: goal.on_lease(lease))
        elif not executor.is_over:
            executor.deliver(decode(Lease, sample.payload))

    def _end_before_claim(self, stop: StopLevel) -> None:
        """The gate ends claims; a goal without one yet must not begin after the stop's reset.

        A stop by nobody, as the gate's own, is seen in the leases (`BeforeClaim`).
        """
        self._stops += 1
        goal = self._goal
        if goal is not None and goal.result is None and goal.executor is None:
            goal.cancel(f"{stop.by}, who stopped the robot: {stop.reason}")

    # --- goals ---------------------------------------------------------------------

    async def _on_goal(self, payload: bytes) -> GoalAccepted:
        goal = decode(Goal, payload)
        self._refuse_while_one_runs()
        stops = self._stops
        gate = await gate_status(self._bus, self._keys)  # first: it may have to wait for its turn
        async with self._accepting:
            self._refuse_while_one_runs()
            admission = await asyncio.to_thread(self._skills.find, goal.skill)
            skill = admission.skill
            check_goal(goal, skill)
            if self._hal is not None:
                await asyncio.to_thread(admission.require, self._hal)
            worker = await self._skills.worker(skill)
            if self._stops != stops:
                why = f"the robot was stopped while the goal of skill {skill.id} was looked at"
                raise RefusedError(self._source, why, "fairlead status")
            goal_id = secrets.randbits(64) or 1
            self._hear(skill)
            self._goal = GoalRun(self._around, goal_id, goal, admission, worker, gate)
            self._goal_task = self._tasks.create_task(self._run(self._goal), name="goal")
        by = f", by {goal.by}" if goal.by else ""
        self._log.info("goal %016x accepted: %s%s", goal_id, skill.id, by)
        return GoalAccepted(goal_id=goal_id)

    async def _run(self, goal: GoalRun) -> None:
        """Its result is said before another goal can be accepted."""
        await goal.run()
        self._publish_change(goal)

    async def _on_load(self, payload: bytes) -> Done:
        """Load a policy, also while a goal of another one runs: so its own goal begins at once.

        Answers once it is loaded, or while it still loads: to be asked again.
        """
        request = decode(Load, payload)
        async with self._accepting:
            admission = await asyncio.to_thread(self._skills.find, request.skill)
            skill, running = admission.skill, self._running()
            if running is not None and await asyncio.to_thread(
                self._skills.share_a_policy, skill, running.skill
            ):
                return Done(text=f"skill {skill.id}: its policy answers the goal that runs")
            worker = await self._skills.worker(skill)
            self._hear(skill)
        loading = self._loads.get(skill.id)
        if loading is None or loading.done():
            loading = self._tasks.create_task(self._load_ahead(skill.id, worker), name="load")
            self._loads[skill.id] = loading
        await asyncio.wait({loading}, timeout=_LOAD_ANSWER_S)  # who gives up does not end it
        if not loading.done():
            return Done(text=f"skill {skill.id} {BEING_LOADED}")
        if why := loading.result():
            raise RefusedError(self._source, why, f"fairlead logs {self._source}")
        return Done(text=f"skill {skill.id} is loaded")

    async def _load_ahead(self, skill_id: str, worker: PolicyWorker) -> str:
        """Why it is not loaded, if so."""
        why = ""
        try:
            await worker.load()
        except FairleadError as error:  # its goal tries again, and ends with the reason
            why = f"skill {skill_id} is not loaded: {error}"
            self._log.warning("%s", why)
        except Exception as error:  # noqa: BLE001 - a bug ends no goal
            why = f"skill {skill_id} is not loaded: {error}"
            self._log.exception("skill %s is not loaded", skill_id)
        return why

    def _running(self) -> GoalRun | None:
        done = self._goal_task is None or self._goal_task.done()
        return None if done else self._goal

    def _refuse_while_one_runs(self) -> None:
        running = self._running()
        if running is not None:
            raise RefusedError(
                self._source,
                f"goal {running.goal_id:016x} of skill {running.skill.id} is still running",
                f"fairlead cancel {self._source}",
            )

    async def _on_cancel(self, payload: bytes) -> Done:
        cancel = decode(Cancel, payload)
        goal = self._goal
        if goal is None or goal.goal_id != cancel.goal_id or goal.result is not None:
            raise RefusedError(
                self._source, f"no goal {cancel.goal_id:016x} is running", "fairlead status"
            )
        goal.cancel(cancel.by)
        return Done(text=f"goal {cancel.goal_id:016x} is being cancelled")

    async def _on_status(self, payload: bytes) -> GoalFeedback:
        decode(StatusQuery, payload)
        return self._goal.feedback() if self._goal is not None else no_goal(self._source)

    async def _publish_feedback(self) -> None:
        """On change and at 2 Hz; the result is repeated until the next goal."""
        while True:
            await asyncio.sleep(_CHANGE_CHECK_S)
            self._quiet_s += _CHANGE_CHECK_S
            if self._goal is not None:
                self._publish_change(self._goal)

    def _publish_change(self, goal: GoalRun) -> None:
        feedback, last = goal.feedback(), self._published
        seen = (goal.goal_id, feedback.phase, feedback.last_refusal, feedback.result)
        if seen == last and self._quiet_s < FEEDBACK_S:
            return
        self._feedback.put(feedback)
        if last is not None and feedback.last_refusal not in ("", last[2]):
            self._log.warning("%s", feedback.last_refusal)
        self._published, self._quiet_s = seen, 0.0


def check_goal(goal: Goal, skill: SkillManifest) -> None:
    """Raise `ConfigError` for a goal whose numbers cannot be meant, or for another manifest."""
    if not 0.0 < goal.stall_timeout_s < float("inf"):
        raise ConfigError(
            f"goal: stall_timeout_s: expected more than 0 s, got {goal.stall_timeout_s:g}"
        )
    if goal.skill_hash not in (NO_HASH, skill.skill_hash):
        raise ConfigError(
            f"goal: skill {skill.id}: expected the manifest {skill.skill_hash.hex()[:16]} this "
            f"runner has loaded, got {goal.skill_hash.hex()[:16]}"
        )
