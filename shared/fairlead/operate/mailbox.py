"""From the transport's threads to an event loop: a bounded queue, never a queue of callbacks."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from fairlead.messages import Message, decode
from fairlead.wire.bus import Bus, Sample
from fairlead.wire.on_loop import call_on

WATCHED = 256
"""Messages that wait at most for a loop that is busy: some seconds of a key."""

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
    """Call ``handler`` on this loop with every message of a key."""

    def drain() -> None:
        while taken := mailbox.take():
            handler(taken[0])

    mailbox = Mailbox(bus, key_expr, lambda heard: decode(kind, heard.payload), WATCHED, drain)
    return mailbox
