"""Waiting for what is announced, also in a task that was cancelled and cleans up."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from fairlead.errors import NoAnswerError
from fairlead.messages import Done, StatusQuery
from fairlead.operate.changes import Changes
from fairlead.wire.memory_bus import MemoryBus
from fairlead.wire.on_loop import ask
from tests.client.turns import turns

pytestmark = pytest.mark.asyncio


async def cleaned_up(doing: Callable[[], Awaitable[object]]) -> object:
    """What a task that is cancelled gets from what it awaits before it ends."""
    got: list[object] = []

    async def run() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            got.append(await doing())

    task = asyncio.create_task(run())
    await turns()
    task.cancel()
    await asyncio.wait({task})
    assert task.cancelled()
    return got[0] if got else "cancelled"


async def test_a_cancelled_task_waits_as_long_as_it_asks_for() -> None:
    changes = Changes()
    assert await cleaned_up(lambda: changes.wait_for(lambda: False, 0.01)) is False


async def test_waiting_for_no_time_lets_others_run() -> None:
    ran: list[bool] = []
    asyncio.get_running_loop().call_soon(ran.append, True)
    assert not await Changes().wait_for(lambda: False, 0.0)
    assert ran


async def test_a_cancelled_task_that_gets_no_answer_is_told_so() -> None:
    async def asked() -> object:
        with pytest.raises(NoAnswerError):
            await ask(MemoryBus(), "nobody/answers", StatusQuery(), Done, 0.01)
        return "no answer"

    assert await cleaned_up(asked) == "no answer"
