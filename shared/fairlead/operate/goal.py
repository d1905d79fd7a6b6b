"""One goal from outside: given to a runner, followed to its result, ended if nobody waits."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import dataclass

from fairlead.errors import NoAnswerError, RefusedError, ServiceError
from fairlead.messages import (
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    JointState,
    Outcome,
    Verdict,
)
from fairlead.operate.changes import Changes
from fairlead.operate.protective_stop import request_stop
from fairlead.operate.services import GOAL_TIMEOUT_S, Services
from fairlead.operate.subscription import watch

REFRESH_S = 0.25
CANCEL_TIMEOUT_S = 3.0  # a runner gives its claim back within that
SILENCE_S = 10.0  # a runner speaks of its goal twice a second


_LOG = logging.getLogger(__name__)


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


class RunningGoal:
    """A goal that a runner has accepted.

    ``async for progress in goal`` yields a `Progress` whenever something changes, and at least
    four times a second, until the result. Whoever waits for the goal and is cancelled cancels
    the goal; where the runner does not confirm that within 3 s, or a second cancellation comes
    first, a protective stop is requested. So does leaving its block, or the robot's, early.

    Attributes:
        goal_id: the runner's id for it, 0 until it is accepted.
        stopped: what was done because the runner did not confirm the end, for people; else "".
    """

    def __init__(self, services: Services, runner: str, skill: str) -> None:
        self.runner = runner
        self.skill = skill
        self.goal_id = 0
        self.stopped = ""
        self._is_held = False  # by a stop of ours that a lease listed
        self._services = services
        self._changes = Changes()
        self._feedback: dict[int, GoalFeedback] = {}
        self._silent_s = 0.0  # waited for feedback in vain: not while this program is paused
        self._counts: Counter[str] = Counter()
        self._answered: set[tuple[int, int]] = set()
        self._tick = 0
        self._first: tuple[float, int] | None = None
        self.is_over = False
        self._gone = services.times_gone(runner)
        bus, keys = services.bus, services.keys
        self._heard = [  # before the goal is sent, so that nothing of it is missed
            watch(bus, keys.feedback(runner), GoalFeedback, self._on_feedback),
            watch(bus, keys.verdict(runner), Verdict, self._on_verdict),
            watch(bus, keys.joints, JointState, self._on_joints),
        ]

    # --- for whoever gave it ----------------------------------------------------------

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

    async def result(self) -> GoalResult:
        """How it ended: a goal that failed is a result, no error.

        Raises:
            ServiceError: the runner went away.
            NoAnswerError: the runner is there and says nothing any more.
        """
        while (result := (await self._next()).result) is None:
            pass
        return result

    async def __aiter__(self) -> AsyncIterator[Progress]:
        while True:
            now = await self._next()
            yield now
            if now.result is not None:
                return

    async def cancel(self) -> GoalResult:
        """End it as soon as possible; its parts hold.

        Returns:
            How it ended: cancelled, or by itself a moment before.

        Raises:
            NoAnswerError: the runner does not confirm it; to be sure, stop the robot.
        """
        with suppress(RefusedError):  # it has just ended by itself
            await self._services.cancel(self.runner, self.goal_id)
        await self._changes.wait_for(self._has_ended, CANCEL_TIMEOUT_S)
        if self.progress.result is None:
            raise NoAnswerError(
                f"{self.runner} did not confirm within {CANCEL_TIMEOUT_S:g} s that the goal ended"
            )
        return self.progress.result

    async def __aenter__(self) -> RunningGoal:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.leave()

    # --- its life ---------------------------------------------------------------------

    async def start(self, request: Goal) -> None:
        """Give it to the runner. `RefusedError` says why it was not taken."""
        await self._services.wait_alive(self.runner)
        key = self._services.keys.goal(self.runner)
        asking = asyncio.ensure_future(
            self._services.ask(self.runner, key, request, GoalAccepted, GOAL_TIMEOUT_S)
        )
        try:
            self.goal_id = (await asyncio.shield(asking)).goal_id
        except asyncio.CancelledError:
            try:
                await self._end_as_answered(asking)
            finally:
                self.log_stopped()
            raise
        finally:
            if not self.goal_id:
                self._close()

    def log_stopped(self) -> None:
        """Say what `stopped` says where nobody else will."""
        if self.stopped:
            _LOG.error("%s", self.stopped)

    async def leave(self) -> None:
        """Look on no longer; a goal that has not ended is ended."""
        if not self.is_over:
            await self._end()
        self._close()

    async def _next(self) -> Progress:
        """Where it stands after a change, or after a moment without one."""
        seen, began_s = self._said(), time.monotonic()
        try:
            await self._changes.wait_for(lambda: self._said() != seen, self._patience_s())
        except asyncio.CancelledError:
            await self._end()
            raise
        self._silent_s += min(time.monotonic() - began_s, REFRESH_S)
        now = self.progress
        if now.result is not None:
            self.is_over = True
        elif self._services.times_gone(self.runner) != self._gone:
            self.is_over = True  # its claim ends without heartbeats: the parts hold
            raise ServiceError(
                f"{self.runner} went away while the goal ran; see: fairlead logs {self.runner}"
            )
        elif self._silent_s > SILENCE_S:
            raise NoAnswerError(
                f"{self.runner}: nothing said of the goal for {SILENCE_S:g} s; see: fairlead logs "
                f"{self.runner}"
            )
        return now

    def _has_ended(self) -> bool:
        return self.progress.result is not None

    def _said(self) -> tuple[str, str, GoalResult | None]:
        now = self.progress
        return now.phase, now.last_refusal, now.result

    def _patience_s(self) -> float:
        return 0.0 if self.progress.result is not None else REFRESH_S

    async def _end(self) -> None:
        """Cancel it; stop the robot if that is not confirmed, or a cancellation comes first."""
        if self.is_over:
            return
        self.is_over = True
        try:
            await self.cancel()
        except NoAnswerError:
            await self._stop_robot()
        except asyncio.CancelledError:
            await self._stop_robot()
            raise

    async def _end_as_answered(self, asking: asyncio.Future[GoalAccepted]) -> None:
        """The same while it is not known yet whether the goal has begun."""
        try:
            answered, _ = await asyncio.wait({asking}, timeout=CANCEL_TIMEOUT_S)
            if not answered:  # it holds while the answer is awaited: it may be yes
                await self._stop_robot()
            self.goal_id = (await asyncio.shield(asking)).goal_id
        except RefusedError:
            return
        except NoAnswerError:
            await self._stop_robot()
        except asyncio.CancelledError:
            await self._stop_robot()
            raise
        else:
            await self._end()

    async def _stop_robot(self) -> None:
        said = f"{self.runner} did not confirm that the goal ended"
        if self.progress.result is not None or self._is_held:
            return
        self.stopped = f"{said}, and no stop is confirmed: THE ROBOT MAY MOVE"
        try:
            stop_id = await request_stop(self._services, said)
        except NoAnswerError as error:
            self.stopped += f": {error}"
            return
        self._is_held = True
        self.stopped = (
            f"{said}: a protective stop holds the robot\n  try: fairlead reset {stop_id:016x}"
        )

    # --- what is heard ----------------------------------------------------------------

    def _close(self) -> None:
        for mailbox in self._heard:
            mailbox.close()

    def _on_feedback(self, feedback: GoalFeedback) -> None:
        self._feedback[feedback.goal_id] = feedback
        if feedback.goal_id == self.goal_id:
            self._silent_s = 0.0
        self._changes.announce()

    def _on_verdict(self, verdict: Verdict) -> None:
        chunk = (verdict.claim_id, verdict.seq)
        if chunk not in self._answered:  # a copy sent again is answered again
            self._answered.add(chunk)
            self._counts[Outcome(verdict.outcome).name.lower()] += 1

    def _on_joints(self, state: JointState) -> None:
        self._tick = state.tick
        if self._first is None:
            self._first = (time.monotonic(), state.tick)
