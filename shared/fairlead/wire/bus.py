"""What a service may ask of its transport, and nothing more.

Two implementations ship: `fairlead.wire.session.ZenohBus` (the real one) and
`fairlead.wire.memory_bus.MemoryBus` (one process, synchronous, deterministic).
"""

from __future__ import annotations

import queue
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from fairlead.errors import FairleadError, NoAnswerError
from fairlead.messages import Bytes, Message


class Qos(Enum):
    """How a key is sent. Nothing here ever blocks the sender."""

    HOT = "real-time priority, express, dropped on congestion"
    CAMERA = "data-low priority, dropped on congestion"
    STATUS = "default priority, dropped on congestion"


@dataclass(frozen=True)
class Sample:
    """One received publication; the payload may be a read-only memoryview."""

    key: str
    payload: Bytes


SampleHandler = Callable[[Sample], None]
QueryHandler = Callable[[bytes], Message]
"""Gets the query's payload; returns the reply; raises `FairleadError` to refuse."""
Answer = Callable[[Message | Exception], None]
"""Sends the reply to one query, or its refusal; to be called once, from any thread."""
LaterHandler = Callable[[bytes, Answer], None]
"""Gets the query's payload and the way to answer it, later if it must wait for something."""
ReplyHandler = Callable[[bytes | FairleadError], None]
"""Gets the reply to a query, or the error that stands for it: once, on any thread."""
TokenHandler = Callable[[str, bool], None]
"""Gets a liveliness key and whether its owner is alive."""


class Publisher(Protocol):
    """One declared key."""

    def put(self, message: Message) -> None:
        """Encode and send; never blocks, never raises for a missing reader."""

    def put_bytes(self, payload: bytes) -> None:
        """Send bytes already encoded (re-sends are byte-identical)."""


class Undeclare(Protocol):
    """Something declared on the bus that can be taken back."""

    def undeclare(self) -> None:
        """Take it back: its handler is called no more."""


class Bus(Protocol):
    """Publish, subscribe, query, liveliness.

    Handlers run on the transport's threads, possibly several at once: what they touch
    must be thread-safe, and they must not block.
    """

    def publisher(self, key: str, kind: type[Message], qos: Qos) -> Publisher:
        """Declare a key to send messages of one type on; ``qos`` says how they travel."""

    def subscribe(self, key_expr: str, handler: SampleHandler) -> Undeclare:
        """Call ``handler`` for every sample on a key, or on all that match a ``*``.

        A `MessageError` that it raises is said once a key and hour, and nothing else comes of it.
        """

    def subscribe_frames(self, key: str, handler: SampleHandler) -> Undeclare:
        """As `subscribe`, for one camera's key: within a host without copies where it can be."""

    def serve(self, key: str, who: str, handler: QueryHandler) -> Undeclare:
        """Answer queries on ``key``; what the handler raises becomes a `Refusal` from ``who``."""

    def serve_later(self, key: str, who: str, handler: LaterHandler) -> Undeclare:
        """Likewise, for a handler whose answer takes its time: it returns at once."""

    def ask(self, key: str, request: Message, timeout_s: float, on_reply: ReplyHandler) -> None:
        """Ask and return at once; ``on_reply`` gets what `query` would return or raise.

        Raises:
            TransportError: the session has closed.
        """

    def query(self, key: str, request: Message, timeout_s: float) -> bytes:
        """Ask and wait for one reply.

        Raises:
            RefusedError: the service answered no.
            NoAnswerError: nobody answered within ``timeout_s``.
        """

    def declare_token(self, key: str) -> Undeclare:
        """Announce a liveliness token for as long as this session lives."""

    def watch_tokens(self, key_expr: str, handler: TokenHandler) -> Undeclare:
        """Call ``handler`` for every token alive now and for each change afterwards."""

    def close(self) -> None:
        """Take everything back that was declared and end the session."""


def wait_for_reply(bus: Bus, key: str, request: Message, timeout_s: float) -> bytes:
    """What `Bus.query` does, by means of `Bus.ask`."""
    replies: queue.SimpleQueue[bytes | FairleadError] = queue.SimpleQueue()
    bus.ask(key, request, timeout_s, replies.put)
    try:
        reply = replies.get(timeout=timeout_s)
    except queue.Empty:
        raise no_answer(key, timeout_s) from None
    if isinstance(reply, FairleadError):
        raise reply
    return reply


def no_answer(key: str, timeout_s: float | None) -> NoAnswerError:
    """What to say where nobody answered in time; None: nobody is there who could, any more."""
    why = "nobody there answers" if timeout_s is None else f"no answer within {timeout_s:g} s"
    return NoAnswerError(f"{key}: {why}; see: fairlead ps")
