"""Goals, claims and subscriptions for programs that block."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Any, Generic, TypeVar

import numpy.typing as npt

from fairlead.errors import TransportError
from fairlead.messages import ActionPart, ClaimReply, GoalResult, Verdict
from fairlead.modes import ControlMode
from fairlead.operate.goal import RunningGoal
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.part_claim import PartClaim
from fairlead.operate.robot import CLOSED
from fairlead.operate.services import ANSWER_TIMEOUT_S
from fairlead.operate.subscription import Subscription
from fairlead.operate.tick import Tick
from fairlead.wire.on_loop import call_on

SIGNAL_S = 0.2
"""Ctrl-C that the system hands to another thread is heard here after so long at most."""

T = TypeVar("T")


class LoopThread:
    """Runs coroutines for the threads that call it; Ctrl-C there cancels them and waits."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._is_closing = False
        self._waiting: set[Future[Any]] = set()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(
            target=self._loop.run_forever, name="fairlead client", daemon=True
        )
        self._thread.start()

    def run(self, doing: Coroutine[Any, Any, T]) -> T:
        """Run one coroutine to its end, from any other thread.

        Raises:
            KeyboardInterrupt: Ctrl-C while it ran; it was cancelled and has ended. Each further
                Ctrl-C cancels it once more.
            TransportError: closed before, or meanwhile.
        """
        ended: Future[T] = Future()
        task = _LoopTask(self._loop, doing, ended)
        with _ctrl_c_calls(task.cancel):
            with self._lock:  # what begins does so before the loop is told to end
                is_closed = self._is_closing
                if not is_closed:
                    self._waiting.add(ended)
                    self._loop.call_soon_threadsafe(task.start)
            if is_closed:
                doing.close()
                raise TransportError(CLOSED)
            try:
                _wait(ended)
            finally:
                self._waiting.discard(ended)
        if task.interrupts:
            raise KeyboardInterrupt
        try:
            return ended.result()
        except asyncio.CancelledError:
            if self._is_closing:
                raise TransportError(CLOSED) from None
            raise

    def iterate(self, iterator: AsyncIterator[T]) -> Iterator[T]:
        """Go through an asynchronous iterator, one element at a time."""
        while found := self.run(_next_of(iterator)):
            yield found[0]

    def close(self) -> None:
        """End the loop, and what still runs on it."""
        with self._lock:
            if self._is_closing:
                return
            self._is_closing = True
        ended: Future[None] = Future()
        task = _LoopTask(self._loop, _cancel_others(), ended)
        with _ctrl_c_calls(task.cancel):
            self._loop.call_soon_threadsafe(task.start)
            _wait(ended)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        for one in list(self._waiting):
            if not one.done():
                one.set_exception(TransportError(CLOSED))
        if task.interrupts:
            raise KeyboardInterrupt
        ended.result()


class _LoopTask(Generic[T]):
    """A coroutine on the loop of another thread. Cancelled early, it has still begun."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, doing: Coroutine[Any, Any, T], ended: Future[T]
    ) -> None:
        self._loop, self._doing, self._ended = loop, doing, ended
        self._task: asyncio.Task[T] | None = None
        self._is_cancelled = False
        self.interrupts = 0

    def start(self) -> None:
        """To be called on the loop."""
        self._task = self._loop.create_task(self._doing)
        self._task.add_done_callback(lambda task: _hand_on(task, self._ended))
        if self._is_cancelled:
            self._cancel()

    def cancel(self) -> None:
        """To be called on another thread."""
        self.interrupts += 1
        call_on(self._loop, self._cancel)

    def _cancel(self) -> None:
        self._is_cancelled = True
        if self._task is not None:
            self._loop.call_soon(self._task.cancel)  # after its first step


def _wait(ended: Future[T]) -> None:
    while not ended.done():
        with suppress(TimeoutError):
            ended.exception(SIGNAL_S)


@contextmanager
def _ctrl_c_calls(function: Callable[[], None]) -> Iterator[None]:
    """Have Ctrl-C call a function where it would raise `KeyboardInterrupt`: in the main thread.

    What is raised somewhere between two steps would leave the task running and nobody waiting.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, lambda number, frame: function())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _hand_on(task: asyncio.Task[T], ended: Future[T]) -> None:
    error = asyncio.CancelledError() if task.cancelled() else task.exception()
    if error is not None:
        ended.set_exception(error)
    else:
        ended.set_result(task.result())


async def _next_of(iterator: AsyncIterator[T]) -> tuple[T] | None:
    try:
        return (await anext(iterator),)
    except StopAsyncIteration:
        return None


async def _cancel_others() -> None:
    while others := asyncio.all_tasks() - {asyncio.current_task()}:
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
    await asyncio.get_running_loop().shutdown_asyncgens()
    await asyncio.get_running_loop().shutdown_default_executor()


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

    def __exit__(self, *_: object) -> None:
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

    def close(self) -> None:
        """As `Subscription.close`."""
        self._thread.run(self._subscription.__aexit__())  # on the loop, as all of it

    def __iter__(self) -> Iterator[T]:
        return self._thread.iterate(self._subscription)

    def __enter__(self) -> BlockingSubscription[T]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
