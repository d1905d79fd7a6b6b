"""Messages of one key, kept until a test asks for them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from fairlead.messages import Message, decode
from fairlead.wire.bus import Bus, Sample

M = TypeVar("M", bound=Message)

DEADLINE_S = 10.0
"""How long a test waits for something that must happen; far beyond any promise."""


class Mailbox(Generic[M]):
    """Every message of type ``kind`` that arrived on ``key``, in order."""

    def __init__(self, bus: Bus, key: str, kind: type[M]) -> None:
        self._kind = kind
        self.key = key
        self._changed = threading.Condition()
        self._frames: list[bytes] = []  # decoded when read: the callback must not take long
        self._read = 0
        self._subscription = bus.subscribe(key, self._on_sample)

    def close(self) -> None:
        """Hear no more."""
        self._subscription.undeclare()

    def _on_sample(self, sample: Sample) -> None:
        with self._changed:
            self._frames.append(sample.payload)
            self._changed.notify_all()

    def wait_for(
        self, accept: Callable[[M], bool] = lambda _: True, timeout_s: float = DEADLINE_S
    ) -> M:
        """The first message not read before that ``accept`` takes; earlier ones count as read."""
        deadline = time.monotonic() + timeout_s
        with self._changed:
            while True:
                while self._read < len(self._frames):
                    message = decode(self._kind, self._frames[self._read])
                    self._read += 1
                    if accept(message):
                        return message
                if not self._changed.wait(deadline - time.monotonic()):
                    last = decode(self._kind, self._frames[-1]) if self._frames else None
                    raise AssertionError(f"{self.key}: not in {timeout_s} s; the last was {last}")

    def skip(self) -> None:
        """Count everything that has arrived as read."""
        with self._changed:
            self._read = len(self._frames)

    def unread(self) -> list[M]:
        """What has arrived and was not read; reads it."""
        with self._changed:
            frames = self._frames[self._read :]
            self._read = len(self._frames)
            return [decode(self._kind, frame) for frame in frames]
