"""An event loop on a thread of its own, for callers that block."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

SIGNAL_S = 0.2
"""Ctrl-C that the system hands to another thread is heard here after so long at most."""

T = TypeVar("T")


class LoopThread:
    """Runs coroutines for the threads that call it; Ctrl-C there cancels them and waits."""

    def __init__(self) -> None:
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
        """
        ended: Future[T] = Future()
        tasks: list[asyncio.Task[T]] = []
        interrupts = 0

        def start() -> None:
            tasks.append(self._loop.create_task(doing))
            tasks[0].add_done_callback(lambda task: _hand_on(task, ended))

        def cancel() -> None:
            nonlocal interrupts
            interrupts += 1
            self._loop.call_soon_threadsafe(lambda: tasks[0].cancel())

        with _ctrl_c_calls(cancel):
            self._loop.call_soon_threadsafe(start)
            while not ended.done():
                with suppress(TimeoutError):
                    ended.exception(SIGNAL_S)
        if interrupts:
            raise KeyboardInterrupt
        return ended.result()

    def iterate(self, iterator: AsyncIterator[T]) -> Iterator[T]:
        """Go through an asynchronous iterator, one element at a time."""
        while found := self.run(_next_of(iterator)):
            yield found[0]

    def close(self) -> None:
        """End the loop, and what still runs on it."""
        self.run(_cancel_others())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


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
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
    await asyncio.get_running_loop().shutdown_asyncgens()
    await asyncio.get_running_loop().shutdown_default_executor()
