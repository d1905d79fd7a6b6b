"""The runner on its bus: goals in, messages to the goal that runs, feedback out."""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from fairlead.errors import RefusedError
from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    Cancel,
    Done,
    Goal,
    GoalAccepted,
    GoalFeedback,
    HalStatus,
    Heartbeat,
    Image,
    JointState,
    LayoutState,
    Lease,
    Message,
    StatusQuery,
    TaskState,
    Verdict,
    decode,
)
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import require_admission
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead_skill_runner.goal_check import check_goal
from fairlead_skill_runner.goal_run import GoalRun, Surroundings, no_goal
from fairlead_skill_runner.heartbeat import HeartbeatThread
from fairlead_skill_runner.offered_skills import OfferedSkills
from fairlead_skill_runner.run_core import Output, RunCore

FEEDBACK_S = 0.5
_CHANGE_CHECK_S = 0.05

M = TypeVar("M", bound=Message)
Handle = Callable[[RunCore, M, float], Sequence[Output]]


class SkillRunner:
    """Runs one goal at a time.

    Args:
        trace_file: where each goal writes what its policy saw and said; None: nowhere.
    """

    def __init__(
        self,
        bus: Bus,
        keys: Keys,
        source: str,
        robot: RobotManifest,
        skills: OfferedSkills,
        trace_file: Path | None = None,
    ) -> None:
        self._bus, self._keys, self._source = bus, keys, source
        self._robot, self._skills = robot, skills
        self._log = logging.getLogger(source)
        self._heard: set[str] = set()
        self._hal: HalStatus | None = None
        self._goal: GoalRun | None = None
        self._goal_thread: threading.Thread | None = None
        self._goal_lock = threading.Lock()
        self._stopping = threading.Event()
        self._feedback = bus.publisher(keys.feedback(source), GoalFeedback, Qos.STATUS)
        self._around = Surroundings(
            source=source,
            bus=bus,
            keys=keys,
            robot=robot,
            candidate=bus.publisher(keys.candidate(source), ActionChunk, Qos.HOT),
            heartbeat=HeartbeatThread(bus.publisher(keys.heartbeat(source), Heartbeat, Qos.HOT)),
            trace_file=trace_file,
        )
        self._subscribe_all()
        bus.serve(keys.goal(source), source, self._on_goal)
        bus.serve(keys.cancel(source), source, self._on_cancel)
        bus.serve(keys.feedback(source), source, self._on_status)
        self._feedback_thread = threading.Thread(
            target=self._publish_feedback, name="feedback", daemon=True
        )
        self._feedback_thread.start()

    def close(self) -> None:
        """End the goal that runs, give its claim back, end the policies."""
        with self._goal_lock:
            goal, thread = self._goal, self._goal_thread
        if goal is not None and thread is not None:
            goal.cancel("the runner, which is shutting down")
            self._skills.close()
            thread.join()
        self._stopping.set()
        self._feedback_thread.join()
        self._around.heartbeat.close()
        self._skills.close()

    # --- messages ------------------------------------------------------------------

    def _subscribe_all(self) -> None:
        keys = self._keys
        self._forward(keys.joints, JointState, lambda core, m, now_s: core.on_joints(m, now_s))
        self._forward(keys.task, TaskState, lambda core, m, now_s: core.on_task(m, now_s))
        self._forward(keys.lease, Lease, lambda core, m, now_s: core.on_lease(m))
        self._forward(
            keys.verdict(self._source), Verdict, lambda core, m, now_s: core.on_verdict(m, now_s)
        )
        self._bus.subscribe(keys.hal_status, self._on_hal_status)
        for skill in self._skills.at_start().values():
            self._hear(skill)

    def _hear(self, skill: SkillManifest) -> None:
        """Subscribe to the layout and the cameras of a skill, each key once."""
        keys = self._keys
        layout, cameras = keys.layout(skill.id), {image.camera for image in skill.images.values()}
        for key in {layout, *map(keys.camera, cameras)} - self._heard:
            self._heard.add(key)
            if key == layout:
                self._forward(key, LayoutState, lambda core, m, now_s: core.on_layout(m, now_s))
            else:
                self._forward(key, Image, lambda core, m, now_s: core.on_image(m, now_s))

    def _forward(self, key: str, kind: type[M], handle: Handle[M]) -> None:
        def on_sample(sample: Sample) -> None:
            goal = self._goal
            if goal is None or goal.result is not None:
                return
            message = decode(kind, sample.payload)
            goal.deliver(lambda core, now_s: handle(core, message, now_s))

        self._bus.subscribe(key, on_sample)

    def _on_hal_status(self, sample: Sample) -> None:
        self._hal = status = decode(HalStatus, sample.payload)
        goal = self._goal
        if goal is not None:
            goal.deliver(lambda core, now_s: core.on_hal_status(status))

    # --- goals ---------------------------------------------------------------------

    def _on_goal(self, payload: bytes) -> GoalAccepted:
        goal = decode(Goal, payload)
        skill = self._skills.find(goal.skill)
        check_goal(goal, skill)
        if self._hal is not None:
            require_admission(skill, self._robot, self._hal)
        with self._goal_lock:
            running = self._goal
            if self._goal_thread is not None and self._goal_thread.is_alive():
                assert running is not None
                raise RefusedError(
                    self._source,
                    f"goal {running.goal_id:016x} of skill {running.skill.id} is still running",
                    "fairlead status",
                )
            goal_id = secrets.randbits(64) or 1
            self._hear(skill)
            run = GoalRun(self._around, goal_id, goal, skill, self._skills.worker(skill))
            self._goal = run
            self._goal_thread = threading.Thread(target=run.run, name="goal", daemon=True)
            self._goal_thread.start()
        self._log.info("goal %016x accepted: %s", goal_id, skill.id)
        return GoalAccepted(goal_id=goal_id)

    def _on_cancel(self, payload: bytes) -> Done:
        cancel = decode(Cancel, payload)
        goal = self._goal
        if goal is None or goal.goal_id != cancel.goal_id or goal.result is not None:
            raise RefusedError(
                self._source, f"no goal {cancel.goal_id:016x} is running", "fairlead status"
            )
        goal.cancel(cancel.by)
        return Done(text=f"goal {cancel.goal_id:016x} is being cancelled")

    def _on_status(self, payload: bytes) -> GoalFeedback:
        decode(StatusQuery, payload)
        goal = self._goal
        return goal.feedback() if goal is not None else no_goal(self._source)

    def _publish_feedback(self) -> None:
        """On change and at 2 Hz; the result is repeated until the next goal."""
        last, quiet_s = None, 0.0
        while not self._stopping.wait(_CHANGE_CHECK_S):
            goal = self._goal
            if goal is None:
                continue
            feedback = goal.feedback()
            seen = (goal.goal_id, feedback.phase, feedback.last_refusal, feedback.result)
            quiet_s += _CHANGE_CHECK_S
            if seen != last or quiet_s >= FEEDBACK_S:
                self._feedback.put(feedback)
                if last is not None and feedback.last_refusal not in ("", last[2]):
                    self._log.warning("%s", feedback.last_refusal)
                last, quiet_s = seen, 0.0
