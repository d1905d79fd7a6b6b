"""Letting what else runs on the event loop go on."""

from __future__ import annotations

import asyncio
from collections.abc import Callable


async def until(condition: Callable[[], object]) -> None:
    """Let everything else run until a condition holds; the test's own timeout is the bound."""
    while not condition():  # noqa: ASYNC110 - nothing here waits for a clock
        await asyncio.sleep(0)


async def turns() -> None:
    """Let everything that can go on do so."""
    left = 5
    while left := left - 1:  # noqa: ASYNC110 - likewise
        await asyncio.sleep(0)
