"""Executes one goal: messages, answers and time go into its core, what the core says is done."""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import NoReturn

import numpy as np

from fairlead.messages import (
    GoalFeedback,
    GoalResult,
    HalStatus,
    Image,
    JointState,
    LayoutState,
    Lease,
    Message,
    TaskState,
    Verdict,
)
from fairlead.wire.bus import Publisher
from fairlead.wire.on_loop import call_on
from fairlead_skill_runner.fitted_rows import fitted
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_core import RunCore
from fairlead_skill_runner.run_outputs import AskPolicy, Output, PolicyAnswer, SendChunk
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.trace import TraceRecord, TraceWriter, picture_hashes

_LOG = logging.getLogger(__name__)
_CHECK_S = 0.05

Step = Callable[[RunCore, float], Sequence[Output]]
"""Gives the core something, with the monotonic time [s] at which it came."""


@dataclass(frozen=True)
class Progress:
    """How far a goal is; the numbers are those of `GoalFeedback`."""

    phase: str
    tick: int = 0
    queue_depth: int = 0
    inferences: int = 0
    starved: int = 0
    last_refusal: str = ""


class GoalExecutor:
    """One `RunCore` with its lock, its clock and its policy.

    Messages come on the transport's threads, answers and time on the event loop; the core sees
    them one at a time. A chunk is sent by whoever brought what it needed: no message waits for
    the loop.

    Args:
        candidate: where chunks are proposed.
        trace: where to write what the policy saw and said; None: nowhere.
        tasks: of the runner: a call of the policy may outlast its goal.
    """

    def __init__(
        self,
        setup: RunSetup,
        worker: PolicyWorker,
        candidate: Publisher,
        trace: TraceWriter | None,
        tasks: asyncio.TaskGroup,
    ) -> None:
        self._worker, self._candidate, self._trace = worker, candidate, trace
        self._tasks, self._loop = tasks, asyncio.get_running_loop()
        self._setup, self._over = setup, asyncio.Event()
        self._lock = threading.Lock()
        self._core = RunCore(setup, time.monotonic())
        self._failure: Exception | None = None

    @property
    def is_over(self) -> bool:
        """Whether nothing that comes matters any more."""
        return self._core.is_over() or self._failure is not None

    def deliver(self, message: Message) -> None:
        """Let the core handle one message, and do what it says. Ignored once it is over."""
        self._step(lambda core, now_s: _take(core, message, now_s))

    def cancel(self, by: str) -> None:
        """End the core, unless it is over."""
        self._step(lambda core, now_s: core.cancel(by))

    @property
    def next_seq(self) -> int:
        """Above the numbers of all its chunks."""
        with self._lock:
            return self._core.next_seq

    def progress(self) -> Progress:
        """How the core stands now."""
        with self._lock:
            core = self._core
            return Progress(
                core.phase,
                core.tick,
                core.queue_depth,
                core.inferences,
                core.starved,
                core.last_refusal,
            )

    async def follow(self) -> GoalResult:
        """Returns when the core is over; raises what was raised in it."""
        while not self.is_over:
            with suppress(TimeoutError):
                async with asyncio.timeout(_CHECK_S):
                    await self._over.wait()
            self._step(lambda core, now_s: core.on_time(now_s))
        if self._failure is not None:
            raise self._failure
        assert self._core.result is not None
        return self._core.result

    def _step(self, step: Step) -> None:
        with self._lock:
            if self.is_over:
                return
            try:
                for output in step(self._core, time.monotonic()):
                    self._execute(output)
            except Exception as error:  # noqa: BLE001 - raised where the goal is followed
                self._failure = error
            if self.is_over:
                call_on(self._loop, self._over.set)

    def _execute(self, output: Output) -> None:
        if isinstance(output, SendChunk):
            self._candidate.put_bytes(output.payload)
        else:
            call_on(self._loop, lambda: self._ask(output))

    def _ask(self, question: AskPolicy) -> None:
        self._tasks.create_task(self._infer(question), name=f"inference {question.call}")

    async def _infer(self, question: AskPolicy) -> None:
        """What is raised here ends the goal; raised in the task, it would end the runner."""
        try:
            answer = await self._worker.answer(question.observation)
        except Exception as error:  # noqa: BLE001 - raised where the goal is followed
            if self.is_over:
                _LOG.exception("inference %d, whose goal has ended", question.call)
            self._step(partial(_raise, error))
        else:
            self._step(partial(self._answered, question, answer))

    def _answered(
        self, question: AskPolicy, answer: PolicyAnswer, core: RunCore, now_s: float
    ) -> Sequence[Output]:
        outputs = core.on_policy(question.call, answer, now_s)
        if self._trace is not None and isinstance(answer, np.ndarray):
            payloads = [output.payload for output in outputs if isinstance(output, SendChunk)]
            chunk = payloads[0] if payloads and self._setup.skill.seam is not None else b""
            seen = question.observation
            fits = fitted(self._setup.routes, answer)
            sent = None if fits is answer else fits
            self._trace.write(
                TraceRecord(seen.tick, seen.state, answer, sent, chunk, picture_hashes(seen))
            )
        return outputs


def _raise(error: Exception, core: RunCore, now_s: float) -> NoReturn:
    raise error


def _take(core: RunCore, message: Message, now_s: float) -> Sequence[Output]:
    match message:
        case JointState():
            return core.on_joints(message, now_s)
        case LayoutState():
            return core.on_layout(message, now_s)
        case Verdict():
            return core.on_verdict(message, now_s)
        case Lease():
            return core.on_lease(message)
        case TaskState():
            return core.on_task(message, now_s)
        case Image():
            return core.on_image(message, now_s)
        case HalStatus():
            return core.on_hal_status(message)
    raise TypeError(f"a goal takes no {type(message).__name__}")


def no_goal(source: str) -> GoalFeedback:
    """What a runner says of its goal before the first."""
    return as_feedback(source, 0, "", Progress("idle"), None)


def as_feedback(
    source: str, goal_id: int, skill: str, progress: Progress, result: GoalResult | None
) -> GoalFeedback:
    """How a goal stands."""
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
