"""Queries answered by tasks of an event loop: each gets an answer, whatever happens."""

from __future__ import annotations

import asyncio
import threading

import pytest

from fairlead.errors import RefusedError
from fairlead.messages import Arm, ArmReply, Message, decode
from fairlead.wire.on_loop import AsyncHandler, QueryTasks
from tests.wire.pair import DEADLINE_S, Pair

KEY = "fl/r/cmd"


async def ask(pair: Pair, by: str = "me") -> ArmReply:
    query = asyncio.to_thread(pair.far.query, KEY, Arm(by=by), DEADLINE_S)
    return decode(ArmReply, await query)


async def refusal(pair: Pair) -> RefusedError:
    with pytest.raises(RefusedError) as caught:
        await ask(pair)
    return caught.value


async def serve(
    tasks: asyncio.TaskGroup, pair: Pair, handler: AsyncHandler, timeout_s: float = DEADLINE_S
) -> None:
    QueryTasks(tasks, pair.near, "hal").serve(KEY, handler, timeout_s)
    await asyncio.to_thread(pair.settle)


@pytest.mark.asyncio
async def test_a_handler_runs_on_the_loop_and_waits_there_while_others_are_answered(
    pair: Pair,
) -> None:
    second, threads = asyncio.Event(), set()

    async def handler(payload: bytes) -> Message:
        threads.add(threading.current_thread())
        if decode(Arm, payload).by == "first":
            await second.wait()
            return ArmReply(epoch=1, session=1)
        second.set()
        return ArmReply(epoch=2, session=1)

    async with asyncio.TaskGroup() as tasks:
        await serve(tasks, pair, handler)
        replies = await asyncio.gather(ask(pair, "first"), ask(pair, "second"))
    assert [reply.epoch for reply in replies] == [1, 2]
    assert threads == {threading.current_thread()}


@pytest.mark.asyncio
async def test_a_bug_in_a_handler_is_answered_and_the_loop_goes_on(pair: Pair) -> None:
    async def handler(payload: bytes) -> Message:
        raise KeyError("arm")

    async with asyncio.TaskGroup() as tasks:
        await serve(tasks, pair, handler)
        assert (await refusal(pair)).reason == "internal error, KeyError: 'arm'"
        assert (await refusal(pair)).reason == "internal error, KeyError: 'arm'"


@pytest.mark.asyncio
async def test_a_handler_that_takes_too_long_is_ended_and_answered(pair: Pair) -> None:
    ended = asyncio.Event()

    async def handler(payload: bytes) -> Message:
        try:
            await asyncio.get_running_loop().create_future()
        finally:
            ended.set()
        return ArmReply(epoch=1, session=1)

    async with asyncio.TaskGroup() as tasks:
        await serve(tasks, pair, handler, timeout_s=0.1)
        refused = await refusal(pair)
        assert (refused.reason, refused.fix) == ("not done within 0.1 s", "fairlead logs hal")
    assert ended.is_set()


@pytest.mark.asyncio
async def test_a_query_that_is_under_way_when_the_service_ends_is_answered(pair: Pair) -> None:
    begun = asyncio.Event()

    async def handler(payload: bytes) -> Message:
        begun.set()
        await asyncio.get_running_loop().create_future()
        return ArmReply(epoch=1, session=1)

    async with asyncio.TaskGroup() as tasks:
        await serve(tasks, pair, handler)
        asked = asyncio.create_task(refusal(pair))
        await begun.wait()
        for task in asyncio.all_tasks() - {asyncio.current_task(), asked}:
            task.cancel()
        assert (await asked).reason == "the service is ending"
    assert (await refusal(pair)).reason == "the service is ending", "and one that comes later"
