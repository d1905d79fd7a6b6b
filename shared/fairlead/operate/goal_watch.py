"""Follow one goal from outside: ticks, phase, verdict counts, rate, and its result."""

from __future__ import annotations

import threading
import time
from collections import Counter
from dataclasses import dataclass

from fairlead.messages import GoalFeedback, GoalResult, JointState, Outcome, Verdict, decode
from fairlead.operate.client import RobotClient
from fairlead.wire.bus import Sample


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


class GoalWatch:
    """One runner's; subscribes before the goal is sent, so that nothing of it is missed."""

    def __init__(self, client: RobotClient, runner: str) -> None:
        keys = client.keys
        self._changed = threading.Condition()
        self._feedback: dict[int, GoalFeedback] = {}
        self._verdicts: Counter[str] = Counter()
        self._answered: set[tuple[int, int]] = set()
        self._tick = 0
        self._first: tuple[float, int] | None = None
        self._subscriptions = [
            client.bus.subscribe(keys.feedback(runner), self._on_feedback),
            client.bus.subscribe(keys.verdict(runner), self._on_verdict),
            client.bus.subscribe(keys.joints, self._on_joints),
        ]

    def close(self) -> None:
        """Look on no longer."""
        for subscription in self._subscriptions:
            subscription.undeclare()

    def wait(self, goal_id: int, timeout_s: float) -> Progress:
        """Progress after a result arrived or ``timeout_s`` passed, whichever is first."""
        with self._changed:
            self._changed.wait_for(lambda: self._result(goal_id) is not None, timeout_s)
            return self._progress(goal_id)

    def _result(self, goal_id: int) -> GoalResult | None:
        feedback = self._feedback.get(goal_id)
        return feedback.result if feedback is not None else None

    def _progress(self, goal_id: int) -> Progress:
        feedback = self._feedback.get(goal_id)
        rate_hz = 0.0
        if self._first is not None:
            elapsed_s = time.monotonic() - self._first[0]
            rate_hz = max(0, self._tick - self._first[1]) / max(elapsed_s, 1e-3)
        return Progress(
            phase=feedback.phase if feedback else "waiting",
            tick=self._tick,
            rate_hz=rate_hz,
            verdicts=dict(self._verdicts),
            inferences=feedback.inferences if feedback else 0,
            starved=feedback.starved if feedback else 0,
            last_refusal=feedback.last_refusal if feedback else "",
            result=feedback.result if feedback else None,
        )

    def _on_feedback(self, sample: Sample) -> None:
        feedback = decode(GoalFeedback, sample.payload)
        with self._changed:
            self._feedback[feedback.goal_id] = feedback
            self._changed.notify_all()

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        chunk = (verdict.claim_id, verdict.seq)
        with self._changed:
            if chunk not in self._answered:  # a copy sent again is answered again
                self._answered.add(chunk)
                self._verdicts[Outcome(verdict.outcome).name.lower()] += 1

    def _on_joints(self, sample: Sample) -> None:
        tick = decode(JointState, sample.payload).tick
        with self._changed:
            self._tick = tick
            if self._first is None:
                self._first = (time.monotonic(), tick)
