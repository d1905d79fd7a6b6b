"""Looking on: what is published on a robot's keys, one after the other."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Generic, TypeVar

from fairlead.errors import NoAnswerError
from fairlead.messages import Message
from fairlead.operate.mailbox import Mailbox
from fairlead.wire.bus import Bus, Sample

QUEUE = 100
SILENCE_S = 10.0

T = TypeVar("T")
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Heard:
    """One message and the key it came on; ``at_s`` on this process's monotonic clock."""

    key: str
    message: Message
    at_s: float


class Subscription(Generic[T]):
    """An async iterator over what a key carries, from the moment it was made.

    It keeps as many messages as its queue is long. For a reader that is slower the oldest is
    dropped: `dropped` counts them, and the first is logged as a warning. What is no message of
    the key's kind is dropped and logged too.

    Iterating raises:
        NoAnswerError: nothing was published within the subscription's ``timeout_s``.
    """

    def __init__(
        self,
        bus: Bus,
        name: str,
        key_expr: str,
        read: Callable[[Sample], T],
        queue: int,
        timeout_s: float,
    ) -> None:
        self._name, self._queue = name, queue
        self._timeout_s = timeout_s
        self._arrived = asyncio.Event()
        self._closed = False
        self._warned = False
        self._mailbox = Mailbox(bus, key_expr, read, queue, self._arrived.set)

    @property
    def dropped(self) -> int:
        """Messages that came and were never handed out, because the queue was full."""
        return self._mailbox.dropped

    def close(self) -> None:
        """Listen no longer; whoever iterates comes to the end."""
        if not self._closed:
            self._closed = True
            self._mailbox.close()
            self._arrived.set()

    async def next(self, timeout_s: float) -> T | None:
        """The next one; None if none comes within ``timeout_s``, or it is closed."""
        await asyncio.sleep(0)  # a reader who is always behind still lets the others run
        with suppress(TimeoutError):
            async with asyncio.timeout(max(timeout_s, 0.0)):
                return await self._take()
        return None

    def __aiter__(self) -> Subscription[T]:
        return self

    async def __anext__(self) -> T:
        taken = await self.next(self._timeout_s)
        if taken is not None:
            return taken
        if self._closed:
            raise StopAsyncIteration
        raise NoAnswerError(
            f"topic {self._name}: nothing published within {self._timeout_s:g} s; see: fairlead "
            "topic list"
        )

    async def __aenter__(self) -> Subscription[T]:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    async def _take(self) -> T | None:
        while True:
            self._arrived.clear()  # before looking: what comes after sets it again
            taken = self._mailbox.take()
            if self.dropped and not self._warned:
                self._warned = True
                _LOG.warning(
                    "topic %s: read too slowly, messages are dropped (a queue of %d is full)",
                    self._name,
                    self._queue,
                )
            if taken is not None:
                return taken[0]
            if self._closed:
                return None
            await self._arrived.wait()
