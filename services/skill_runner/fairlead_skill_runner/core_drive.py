"""Drives the core of one goal: messages, answers and time go in, what it says is done."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fairlead.messages import GoalResult
from fairlead.wire.bus import Publisher
from fairlead_skill_runner.inference import InferenceThread
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_core import AskPolicy, Output, PolicyAnswer, RunCore, SendChunk
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.trace import TraceRecord, TraceWriter

_CHECK_S = 0.05

Handle = Callable[[RunCore, float], Sequence[Output]]
"""Gives the core one message, with the monotonic time [s] at which it came."""


@dataclass(frozen=True)
class Progress:
    """How far a goal is; the numbers are those of `GoalFeedback`."""

    phase: str
    tick: int = 0
    queue_depth: int = 0
    inferences: int = 0
    starved: int = 0
    last_refusal: str = ""


class CoreDrive:
    """One `RunCore` with its lock, its clock and its policy.

    Messages come on the transport's threads, answers on the policy's, time on the one that
    calls `follow`; the core sees them one at a time.

    Args:
        candidate: where chunks are proposed.
        trace: where to write what the policy saw and said; None: nowhere.
    """

    def __init__(
        self, setup: RunSetup, worker: PolicyWorker, candidate: Publisher, trace: TraceWriter | None
    ) -> None:
        self._candidate = candidate
        self._lock = threading.RLock()
        self._ended = threading.Event()
        self._trace = trace
        self._inference = InferenceThread(worker, self._on_answer)
        self._core = RunCore(setup, time.monotonic())

    def deliver(self, handle: Handle) -> None:
        """Let the core handle one message, and do what it says. Ignored once it is over."""
        with self._lock:
            if self._core.is_over():
                return
            self._execute(handle(self._core, time.monotonic()))
            if self._core.is_over():
                self._ended.set()

    def cancel(self, by: str) -> None:
        """End the core, unless it is over."""
        with self._lock:
            self._core.cancel(by)
            self._ended.set()

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

    def follow(self) -> GoalResult:
        """Blocks until the core is over."""
        while (result := self._core.result) is None:
            self._ended.wait(_CHECK_S)
            self.deliver(lambda core, now_s: core.on_time(now_s))
        # A policy call may still be running; the claim is not kept waiting for it.
        threading.Thread(target=self._inference.close, daemon=True).start()
        return result

    def _on_answer(self, question: AskPolicy, answer: PolicyAnswer) -> None:
        with self._lock:
            if not self._core.is_over():
                self._record(question, answer)
            self.deliver(lambda core, now_s: core.on_policy(question.call, answer, now_s))

    def _record(self, question: AskPolicy, answer: PolicyAnswer) -> None:
        if self._trace is not None and isinstance(answer, np.ndarray):
            seen = question.observation
            self._trace.write(TraceRecord(tick=seen.tick, state=seen.state, actions=answer))

    def _execute(self, outputs: Sequence[Output]) -> None:
        for output in outputs:
            if isinstance(output, SendChunk):
                self._candidate.put_bytes(output.payload)
            else:
                self._inference.ask(output)
