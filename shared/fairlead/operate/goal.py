"""One goal from outside: given to a runner, followed to its result, ended if nobody waits."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator
from contextlib import suppress

from fairlead.errors import FairleadError, NoAnswerError, RefusedError, ServiceError, TransportError
from fairlead.messages import Goal, GoalAccepted, GoalResult, check_fields
from fairlead.operate.goal_hearing import GoalHearing, Progress
from fairlead.operate.protective_stop import request_stop
from fairlead.operate.services import GOAL_TIMEOUT_S, Services
from fairlead.wire.on_loop import ask

REFRESH_S = 0.25
CANCEL_TIMEOUT_S = 3.0  # a runner gives its claim back within that
SILENCE_S = 10.0  # a runner speaks of its goal twice a second

_LOG = logging.getLogger(__name__)


class RunningGoal:
    """A goal that a runner has accepted.

    ``async for progress in goal`` yields a `Progress` whenever something changes, and at least
    four times a second, until the result. Whoever waits for the goal and is cancelled cancels
    the goal; where the runner does not confirm that within 3 s, or a second cancellation comes
    first, a protective stop is requested. So does leaving its block, or the robot's, early.

    Attributes:
        is_over: nothing of it is left to be ended.
        stopped: what was done because the runner did not confirm the end, for people; else "".
    """

    def __init__(self, services: Services, runner: str, skill: str) -> None:
        self.runner = runner
        self.skill = skill
        self.stopped = ""
        self._is_held = False  # by a stop of ours that a lease listed
        self._services = services
        self._hearing = GoalHearing(services, runner)
        self._changes = self._hearing.changes
        self.is_over = False
        self._asking: asyncio.Future[GoalAccepted] | None = None
        self._confirming: asyncio.Future[None]
        self._ending: asyncio.Future[None] | None = None
        self._gone = services.times_gone(runner)

    # --- for whoever gave it ----------------------------------------------------------

    @property
    def goal_id(self) -> int:
        """The runner's id for it, 0 until it is accepted."""
        return self._hearing.goal_id

    @property
    def progress(self) -> Progress:
        """Where it stands now, without waiting."""
        return self._hearing.progress

    async def result(self) -> GoalResult:
        """How it ended: a goal that failed is a result, no error.

        Raises:
            ServiceError: the runner, or the link to it, went away; to leave the goal's block, or
                the robot's, still ends the goal.
            NoAnswerError: the runner is there and says nothing any more; or it has another goal,
                so that this one has ended, and how was not heard.
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
            NoAnswerError: the runner does not confirm it; to be sure, stop the robot. Or it has
                ended, and how was not heard.
        """
        try:
            await self._services.cancel(self.runner, self.goal_id)
        except RefusedError:  # it has just ended by itself, or with the runner that had it
            with suppress(FairleadError):
                self._hearing.on_answer(await self._services.goal_feedback(self.runner))
        if await self._changes.wait_for(self._has_ended, CANCEL_TIMEOUT_S):
            self._be_over()
        self._check_heard()
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
        """Give it to the runner.

        Raises:
            RefusedError: why it was not taken.
            NoAnswerError, TransportError, MessageError: it was perhaps taken, and nobody knows
                its id; so the robot was stopped, and the log says so.
        """
        try:
            check_fields(request)  # what cannot be sent has not begun
            key = self._services.command(self._services.keys.goal(self.runner))
            await self._services.wait_alive(self.runner)
            if self.is_over:
                raise TransportError(f"left before {self.runner} was asked for the goal")
        except BaseException:
            self._be_over()
            raise
        asking = ask(self._services.bus, key, request, GoalAccepted, GOAL_TIMEOUT_S)
        self._asking = asyncio.ensure_future(asking)
        try:
            self._hearing.goal_id = (await asyncio.shield(self._asking)).goal_id
        except RefusedError:
            self._be_over()
            raise
        except (asyncio.CancelledError, FairleadError):  # it was perhaps accepted
            try:
                await self._end()
            finally:
                self.log_stopped()
            raise

    def log_stopped(self) -> None:
        """Say what `stopped` says where nobody else will."""
        if self.stopped:
            _LOG.error("%s", self.stopped)

    async def leave(self) -> None:
        """Look on no longer; a goal that has not ended is ended."""
        await self._end()

    async def _next(self) -> Progress:
        """Where it stands after a change, or after a moment without one."""
        seen, began_s = self._said(), time.monotonic()
        try:
            await self._changes.wait_for(lambda: self._said() != seen, self._patience_s())
        except asyncio.CancelledError:
            await self._end()
            raise
        self._hearing.silent_s += min(time.monotonic() - began_s, REFRESH_S)
        now = self.progress
        if now.result is not None:
            self._be_over()
            return now
        if self._hearing.has_moved_on:
            self._be_over()
            self._check_heard()
        if self._services.times_gone(self.runner) != self._gone:
            # A hint: it may run on behind a link that is cut. Whoever leaves the goal ends it.
            raise ServiceError(
                f"{self.runner} went away while the goal ran; see: fairlead logs {self.runner}"
            )
        if self._hearing.silent_s > SILENCE_S:
            raise NoAnswerError(
                f"{self.runner}: nothing said of the goal for {SILENCE_S:g} s; see: fairlead logs "
                f"{self.runner}"
            )
        return now

    def _be_over(self) -> None:
        self.is_over = True
        self._hearing.close()

    def _has_ended(self) -> bool:
        return self.progress.result is not None or self._hearing.has_moved_on

    def _check_heard(self) -> None:
        if self._hearing.has_moved_on:
            raise NoAnswerError(
                f"{self.runner} has no longer this goal: it has ended, and how was not heard; see: "
                f"fairlead logs {self.runner}"
            )

    def _said(self) -> tuple[str, str, bool]:
        now = self.progress
        return now.phase, now.last_refusal, self._has_ended()

    def _patience_s(self) -> float:
        return 0.0 if self._has_ended() else REFRESH_S

    async def _end(self) -> None:
        """Have it end, and wait for that; a cancellation meanwhile has the robot stopped at once.

        It goes on to its end also if nobody waits for it any more: `leave` does so again.
        """
        if self.is_over:
            return
        if self._asking is None:  # nobody was asked, and nobody will be
            self._be_over()
            return
        if self._ending is None:
            self._confirming = asyncio.ensure_future(self._confirm(self._asking))
            self._ending = asyncio.ensure_future(self._end_or_stop(self._confirming))
        try:
            await asyncio.shield(self._ending)
        except asyncio.CancelledError:
            self._confirming.cancel()
            await asyncio.wait({self._ending})
            raise

    async def _confirm(self, asking: asyncio.Future[GoalAccepted]) -> None:
        """Cancel it, once it is known whether it has begun."""
        if not self.goal_id:
            answered, _ = await asyncio.wait({asking}, timeout=CANCEL_TIMEOUT_S)
            if not answered:  # the stop holds while the answer is awaited: it may be yes
                await self._stop_robot()
            try:
                self._hearing.goal_id = (await asyncio.shield(asking)).goal_id
            except RefusedError:
                return
        await self.cancel()

    async def _end_or_stop(self, confirming: asyncio.Future[None]) -> None:
        try:
            await asyncio.wait({confirming})
            hurried = confirming.cancelled()
            if not hurried and confirming.exception() is None:
                return
            if hurried or not await self._has_lost_its_claim():
                await self._stop_robot()
        except asyncio.CancelledError:  # the loop ends
            await self._stop_robot()
            raise
        finally:
            self._be_over()

    async def _has_lost_its_claim(self) -> bool:
        """Whether the gate grants nothing to a runner that is gone, and did so before.

        A goal that had no claim yet might still get one.
        """
        if self._has_ended():
            return True
        if self.runner in self._services.alive or not self.progress.verdicts:
            return False
        with suppress(FairleadError):
            gate = await self._services.gate_status()
            return all(claim.source != self.runner for claim in gate.claims)
        return False

    async def _stop_robot(self) -> None:
        said = f"{self.runner} did not confirm that the goal ended"
        if self._has_ended() or self._is_held:
            return
        self.stopped = f"{said}, and no stop is confirmed: THE ROBOT MAY MOVE"
        try:
            stop_id = await request_stop(self._services, said)
        except FairleadError as error:
            self.stopped += f": {error}"
            return
        self._is_held = True
        self.stopped = (
            f"{said}: a protective stop holds the robot\n  try: fairlead reset {stop_id:016x}"
        )
