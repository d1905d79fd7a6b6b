"""What a runner, the gate and the HAL say of one goal, and where it stands by that."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass

from fairlead.messages import GoalFeedback, GoalResult, JointState, Outcome, Verdict
from fairlead.operate.changes import Changes
from fairlead.operate.services import Services
from fairlead.operate.subscription import watch


@dataclass(frozen=True)
class Progress:
    """Where a goal stands now.

    tick: newest tick seen. rate_hz: ticks a second since the watch began.
    verdicts: chunks by outcome (``released``, ``truncated``, ``refused``).
    """

    phase: str
    tick: int
    rate_hz: float
    verdicts: dict[str, int]
    inferences: int
    starved: int
    last_refusal: str
    result: GoalResult | None

    def line(self) -> str:
        """One line for a terminal."""
        counts = ", ".join(f"{count} {name}" for name, count in sorted(self.verdicts.items()))
        refusal = f" | last refusal: {self.last_refusal}" if self.last_refusal else ""
        return (
            f"tick {self.tick:5d} | {self.phase:<12} | verdicts: {counts or 'none yet'} | "
            f"{self.rate_hz:5.1f} ticks/s | starved {self.starved}{refusal}"
        )


class GoalHearing:
    """Listens from before the goal is sent, so that nothing of it is missed.

    Attributes:
        goal_id: the runner's id for it, 0 until it is accepted.
        changes: announces what is heard of any goal of the runner.
        has_moved_on: the runner has another goal, or none that it knows of: ours has ended, and
            its result was not heard.
        silent_s: waited for feedback in vain: not while this program is paused.
    """

    def __init__(self, services: Services, runner: str) -> None:
        self.goal_id = 0
        self.changes = Changes()
        self.has_moved_on = False
        self.silent_s = 0.0
        self._feedback: dict[int, GoalFeedback] = {}
        self._counts: Counter[str] = Counter()
        self._answered: set[tuple[int, int]] = set()
        self._tick = 0
        self._first: tuple[float, int] | None = None
        bus, keys = services.bus, services.keys
        self._heard = [
            watch(bus, keys.feedback(runner), GoalFeedback, self._on_feedback),
            watch(bus, keys.verdict(runner), Verdict, self._on_verdict),
            watch(bus, keys.joints, JointState, self._on_joints),
        ]

    @property
    def progress(self) -> Progress:
        """Where it stands now, without waiting."""
        feedback = self._feedback.get(self.goal_id)
        rate_hz = 0.0
        if self._first is not None:
            elapsed_s = time.monotonic() - self._first[0]
            rate_hz = max(0, self._tick - self._first[1]) / max(elapsed_s, 1e-3)
        return Progress(
            phase=feedback.phase if feedback else "waiting",
            tick=self._tick,
            rate_hz=rate_hz,
            verdicts=dict(self._counts),
            inferences=feedback.inferences if feedback else 0,
            starved=feedback.starved if feedback else 0,
            last_refusal=feedback.last_refusal if feedback else "",
            result=feedback.result if feedback else None,
        )

    def close(self) -> None:
        """Listen no longer; what was heard stays."""
        while self._heard:
            self._heard.pop().close()

    def on_answer(self, feedback: GoalFeedback) -> None:
        """What the runner answers, asked for its newest goal after ours was accepted."""
        self._take(feedback, is_newer=True)

    def _on_feedback(self, feedback: GoalFeedback) -> None:
        # Before ours, the one before ours may still be spoken of.
        self._take(feedback, is_newer=self.goal_id in self._feedback)

    def _take(self, feedback: GoalFeedback, *, is_newer: bool) -> None:
        self._feedback[feedback.goal_id] = feedback
        if feedback.goal_id == self.goal_id:
            self.silent_s = 0.0
        elif is_newer and self.progress.result is None:
            self.has_moved_on = True
        self.changes.announce()

    def _on_verdict(self, verdict: Verdict) -> None:
        chunk = (verdict.claim_id, verdict.seq)
        if chunk not in self._answered:  # a copy sent again is answered again
            self._answered.add(chunk)
            self._counts[Outcome(verdict.outcome).name.lower()] += 1

    def _on_joints(self, state: JointState) -> None:
        self._tick = state.tick
        if self._first is None:
            self._first = (time.monotonic(), state.tick)
