"""Waiting, on an event loop, for something that a callback will change."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine
from typing import TypeVar

T = TypeVar("T")


class Changes:
    """Wakes those who wait on this loop for a condition, whenever something was announced."""

    def __init__(self) -> None:
        self._waiting: set[asyncio.Future[None]] = set()

    def announce(self) -> None:
        """Let everybody who waits look again; to be called on the loop."""
        for waiting in self._waiting:
            if not waiting.done():
                waiting.set_result(None)
        self._waiting.clear()

    async def wait_for(self, condition: Callable[[], bool], timeout_s: float | None) -> bool:
        """Wait until the condition holds; whether it does after at most ``timeout_s``.

        None: for as long as whoever asks is not cancelled.
        """
        loop = asyncio.get_running_loop()
        end_s = math.inf if timeout_s is None else loop.time() + timeout_s
        while not condition():
            left_s = None if timeout_s is None else max(0.0, end_s - loop.time())
            await self._next(left_s)
            if loop.time() >= end_s:
                return condition()
        return True

    async def _next(self, timeout_s: float | None) -> None:
        """Until something is announced, or the time is over.

        Not by `asyncio.timeout`: before Python 3.11.3 its end is a cancellation in a task that
        is being cancelled, and such a task may wait here for a stop to be confirmed.
        """
        waiting = asyncio.get_running_loop().create_future()
        self._waiting.add(waiting)
        try:
            await asyncio.wait({waiting}, timeout=timeout_s)
        finally:
            self._waiting.discard(waiting)


async def unbroken(doing: Coroutine[None, None, T]) -> T:
    """Do something to its end, also if the task is cancelled meanwhile: it is cancelled then.

    A second cancellation does not wait.
    """
    task = asyncio.ensure_future(doing)
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        await asyncio.wait({task})
        raise
