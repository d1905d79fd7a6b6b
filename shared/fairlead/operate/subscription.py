"""Looking on: what is published on a robot's keys, one after the other."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, Generic, TypeVar

from fairlead.errors import ConfigError, NoAnswerError, expected
from fairlead.messages import Message, decode
from fairlead.wire.bus import Bus, Sample
from fairlead.wire.on_loop import call_on

WATCHED = 256
"""Messages that wait at most for a loop that is busy: some seconds of a key."""

_LOG = logging.getLogger(__name__)

T = TypeVar("T")
M = TypeVar("M", bound=Message)


class Mailbox(Generic[T]):
    """What was published on some keys and not read yet, in order of arrival.

    When it is full the oldest is dropped, and counted. What cannot be read never comes in.

    Args:
        read: makes of a sample what is kept, on a thread of the transport.
        size: how many are kept.
        on_arrival: called on the loop that made the mailbox when something comes into the
            empty mailbox.
    """

    def __init__(
        self,
        bus: Bus,
        key_expr: str,
        read: Callable[[Sample], T],
        size: int,
        on_arrival: Callable[[], None],
    ) -> None:
        self.dropped = 0
        self._read = read
        self._size = size
        self._on_arrival = on_arrival
        self._loop = asyncio.get_running_loop()
        self._kept: deque[T] = deque()
        self._lock = threading.Lock()
        self._subscription = bus.subscribe(key_expr, self._on_sample)

    def take(self) -> tuple[T] | None:
        """The oldest that is kept, None if there is none."""
        with self._lock:
            return (self._kept.popleft(),) if self._kept else None

    def close(self) -> None:
        """Listen no longer; what is kept can still be taken."""
        self._subscription.undeclare()

    def _on_sample(self, sample: Sample) -> None:
        read = self._read(sample)
        with self._lock:
            was_empty = not self._kept
            if len(self._kept) == self._size:
                self._kept.popleft()
                self.dropped += 1
            self._kept.append(read)
        if was_empty:
            call_on(self._loop, self._on_arrival)


def watch(bus: Bus, key_expr: str, kind: type[M], handler: Callable[[M], None]) -> Mailbox[Any]:
    """Call ``handler`` on this loop with every message of a key; what it raises is logged."""

    def drain() -> None:
        while taken := mailbox.take():
            try:
                handler(taken[0])
            except Exception:  # noqa: BLE001 - those after it are still to be handled
                _LOG.exception("%s: %s cannot be handled", key_expr, kind.__name__)

    mailbox = Mailbox(bus, key_expr, lambda heard: decode(kind, heard.payload), WATCHED, drain)
    return mailbox


QUEUE = 100
SILENCE_S = 10.0


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

    Raises:
        ConfigError: a queue that holds nothing, or a time that is none.
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
        self._closed = True  # nothing to close yet
        if not isinstance(queue, int | Integral) or queue < 1:
            what = "a whole number from 1"
            raise ConfigError(expected(f"topic {name}: queue", what, repr(queue)))
        if not isinstance(timeout_s, float | Real) or not timeout_s >= 0:
            what = "seconds, at least 0"
            raise ConfigError(expected(f"topic {name}: timeout_s", what, repr(timeout_s)))
        self._name, self._queue = name, queue
        self._timeout_s = timeout_s
        self._loop = asyncio.get_running_loop()
        self._arrived = asyncio.Event()
        self._warned = False
        self._mailbox = Mailbox(bus, key_expr, read, queue, self._arrived.set)
        self._closed = False

    def __del__(self) -> None:
        # On the loop: garbage is also collected on Zenoh's threads, which undeclaring waits for.
        if not self._closed:
            call_on(self._loop, self._mailbox.close)

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

    async def __aexit__(self, *_: object) -> None:
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
