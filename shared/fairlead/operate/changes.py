"""Waiting, on an event loop, for something that a callback will change."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress
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
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                while not condition():
                    await self._next()
        return condition()

    async def _next(self) -> None:
        waiting = asyncio.get_running_loop().create_future()
        self._waiting.add(waiting)
        try:
            await waiting
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
