"""A session for an event loop; queries from it, and answered there, each within a deadline."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from typing import TypeVar

from fairlead.errors import FairleadError, RefusedError
from fairlead.keys import of_person, person_of
from fairlead.messages import Cancel, Goal, Load, Message, ResetEpisode, check_fields, decode
from fairlead.wire.bus import Answer, Bus, Undeclare, no_answer
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

_LOG = logging.getLogger("query")

Reply = TypeVar("Reply", bound=Message)
Command = Goal | Cancel | Load | ResetEpisode
"""What has ``by`` and is asked of Python services."""
AsyncHandler = Callable[[bytes], Awaitable[Message]]
"""Gets the query's payload; returns the reply; raises `FairleadError` to refuse."""


def call_on(loop: asyncio.AbstractEventLoop, function: Callable[[], None]) -> None:
    """Have a loop call a function, from any thread; a loop that has ended calls nothing."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(function)


async def open_session(endpoints: Endpoints) -> ZenohBus:
    """Open a session in a thread, as Zenoh blocks; one that nobody waits for any more is closed.

    Raises:
        TransportError: as `ZenohBus`.
    """
    opening = asyncio.ensure_future(asyncio.to_thread(ZenohBus, endpoints))
    try:
        return await asyncio.shield(opening)
    except asyncio.CancelledError:
        with suppress(FairleadError):
            (await opening).close()
        raise


async def ask(bus: Bus, key: str, request: Message, kind: type[Reply], timeout_s: float) -> Reply:
    """Ask and wait for the reply.

    Raises:
        RefusedError: the service answered no.
        NoAnswerError: nobody answered within ``timeout_s``.
        MessageError: a field of the request is of another kind; what came is no ``kind``.
    """
    check_fields(request)
    loop = asyncio.get_running_loop()
    replied: asyncio.Future[bytes | FairleadError] = loop.create_future()

    def take(reply: bytes | FairleadError) -> None:
        if not replied.done():
            replied.set_result(reply)

    bus.ask(key, request, timeout_s, lambda reply: call_on(loop, lambda: take(reply)))
    await asyncio.wait({replied}, timeout=timeout_s)  # as in `Changes`: no `asyncio.timeout`
    if not replied.done():
        raise no_answer(key, timeout_s)
    reply = replied.result()
    if isinstance(reply, FairleadError):
        raise reply
    return decode(kind, reply)


class QueryTasks:
    """Answers queries by tasks of the loop that it was made on.

    Every query is answered: with what the handler returns, or with a `Refusal` that says what it
    raised, that it took too long, or that the service is ending.

    Args:
        who: the service, as a refusal names it.
    """

    def __init__(self, tasks: asyncio.TaskGroup, bus: Bus, who: str) -> None:
        self._tasks, self._bus, self._who = tasks, bus, who
        self._loop = asyncio.get_running_loop()
        self._ending = RefusedError(who, "the service is ending")

    def serve(self, key: str, handler: AsyncHandler, timeout_s: float) -> Undeclare:
        """Answer queries on ``key``, each within ``timeout_s``; to be called on any thread."""

        def start(payload: bytes, answer: Answer) -> None:
            answering = self._answer(handler, payload, timeout_s, answer)
            try:
                self._tasks.create_task(answering, name=f"query {key}")
            except RuntimeError:  # the group has ended
                answering.close()
                answer(self._ending)

        def on_query(payload: bytes, answer: Answer) -> None:
            try:
                self._loop.call_soon_threadsafe(start, payload, answer)
            except RuntimeError:  # the loop has ended
                answer(self._ending)

        return self._bus.serve_later(key, self._who, on_query)

    def serve_command(
        self,
        key: str,
        kind: type[Command],
        handler: AsyncHandler,
        timeout_s: float,
        people: Sequence[str],
    ) -> list[Undeclare]:
        """As `serve`; where there are people, on the key of each, of whom it then has to be."""
        if not people:
            return [self.serve(key, handler, timeout_s)]
        return [
            self.serve(of_person(key, one), self._only_of(one, kind, handler), timeout_s)
            for one in people
        ]

    def _only_of(self, person: str, kind: type[Command], handler: AsyncHandler) -> AsyncHandler:
        async def handle(payload: bytes) -> Message:
            named = person_of(decode(kind, payload).by)
            if named != person:
                why = f"asked in the name of {named} on the key of {person}"
                _LOG.warning("%s refused a query: %s", self._who, why)
                raise RefusedError(self._who, why, "ask on the key of whoever asks")
            return await handler(payload)

        return handle

    async def _answer(
        self, handler: AsyncHandler, payload: bytes, timeout_s: float, answer: Answer
    ) -> None:
        try:
            async with asyncio.timeout(timeout_s):
                outcome: Message | Exception = await handler(payload)
        except asyncio.CancelledError:
            outcome = self._ending
        except TimeoutError:
            late = f"not done within {timeout_s:g} s"
            outcome = RefusedError(self._who, late, f"fairlead logs {self._who}")
        except Exception as error:  # noqa: BLE001 - a bug is answered too
            outcome = error
        answer(outcome)
