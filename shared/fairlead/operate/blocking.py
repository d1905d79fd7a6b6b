"""Goals, claims and subscriptions for programs that block."""

from __future__ import annotations

from collections.abc import Iterator
from types import TracebackType
from typing import Generic, TypeVar

import numpy.typing as npt

from fairlead.messages import ActionPart, ClaimReply, GoalResult, Verdict
from fairlead.modes import ControlMode
from fairlead.operate.goal import Progress, RunningGoal
from fairlead.operate.loop_thread import LoopThread
from fairlead.operate.part_claim import PartClaim
from fairlead.operate.services import ANSWER_TIMEOUT_S
from fairlead.operate.subscription import Subscription
from fairlead.operate.tick import Tick

T = TypeVar("T")


class BlockingGoal:
    """A `RunningGoal` whose methods block; Ctrl-C in one of them cancels the goal.

    Leaving its ``with`` block early cancels it too.
    """

    def __init__(self, thread: LoopThread, goal: RunningGoal) -> None:
        self._thread, self._goal = thread, goal

    @property
    def stopped(self) -> str:
        """As `RunningGoal.stopped`."""
        return self._goal.stopped

    @property
    def progress(self) -> Progress:
        """As `RunningGoal.progress`."""
        return self._goal.progress

    def result(self) -> GoalResult:
        """As `RunningGoal.result`."""
        return self._thread.run(self._goal.result())

    def cancel(self) -> GoalResult:
        """As `RunningGoal.cancel`."""
        return self._thread.run(self._goal.cancel())

    def log_stopped(self) -> None:
        """As `RunningGoal.log_stopped`."""
        self._goal.log_stopped()

    def __iter__(self) -> Iterator[Progress]:
        return self._thread.iterate(aiter(self._goal))

    def __enter__(self) -> BlockingGoal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._thread.run(self._goal.leave())


class BlockingClaim:
    """A `PartClaim` whose methods block; a thread of its own keeps it alive meanwhile."""

    def __init__(self, thread: LoopThread, claim: PartClaim) -> None:
        self._thread, self._claim = thread, claim

    @property
    def reply(self) -> ClaimReply:
        """As `PartClaim.reply`."""
        return self._claim.reply

    def next_tick(self, timeout_s: float = ANSWER_TIMEOUT_S) -> Tick:
        """As `PartClaim.next_tick`."""
        return self._thread.run(self._claim.next_tick(timeout_s))

    def rows(
        self,
        part: str,
        mode: ControlMode,
        rows: npt.ArrayLike,
        *,
        frame: str = "",
        joints: tuple[str, ...] = (),
    ) -> ActionPart:
        """As `PartClaim.rows`."""
        return self._claim.rows(part, mode, rows, frame=frame, joints=joints)

    def send(self, tick: int, *parts: ActionPart) -> Verdict:
        """As `PartClaim.send`."""
        return self._thread.run(self._claim.send(tick, *parts))

    def release(self) -> None:
        """As `PartClaim.release`."""
        self._thread.run(self._claim.release())

    def __enter__(self) -> BlockingClaim:
        self._thread.run(self._claim.__aenter__())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._thread.run(self._claim.__aexit__(kind, error, trace))


class BlockingSubscription(Generic[T]):
    """A `Subscription` to go through with ``for``."""

    def __init__(self, thread: LoopThread, subscription: Subscription[T]) -> None:
        self._thread, self._subscription = thread, subscription

    @property
    def dropped(self) -> int:
        """As `Subscription.dropped`."""
        return self._subscription.dropped

    def next(self, timeout_s: float) -> T | None:
        """As `Subscription.next`."""
        return self._thread.run(self._subscription.next(timeout_s))

    def __iter__(self) -> Iterator[T]:
        return self._thread.iterate(self._subscription)
