"""The transport without a network: every put is delivered before it returns.

Shipped for notebooks and for driving services' cores in one process. A ``filter`` may
drop, delay, duplicate or reorder: it gets each sample and returns those to deliver now.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from fairlead.errors import FairleadError
from fairlead.messages import Message, encode
from fairlead.wire.bus import (
    LaterHandler,
    Qos,
    QueryHandler,
    ReplyHandler,
    Sample,
    SampleHandler,
    TokenHandler,
    no_answer,
    wait_for_reply,
)
from fairlead.wire.failures import dropping, error_of, refusal_of

SampleFilter = Callable[[Sample], Iterable[Sample]]


def matches(key_expr: str, key: str) -> bool:
    """Whether ``key`` is in ``key_expr`` (``*`` stands for exactly one chunk)."""
    wanted, given = key_expr.split("/"), key.split("/")
    return len(wanted) == len(given) and all(
        w in ("*", g) for w, g in zip(wanted, given, strict=True)
    )


Handler = TypeVar("Handler")


@dataclass(eq=False)
class _Entry(Generic[Handler]):
    registry: list[_Entry[Handler]]
    key: str
    handler: Handler
    on_undeclare: Callable[[], None] | None = None

    def undeclare(self) -> None:
        if self in self.registry:
            self.registry.remove(self)
            if self.on_undeclare:
                self.on_undeclare()


@dataclass
class _MemoryPublisher:
    bus: MemoryBus
    key: str

    def put(self, message: Message) -> None:
        self.put_bytes(encode(message))

    def put_bytes(self, payload: bytes) -> None:
        self.bus.deliver(Sample(self.key, payload))


@dataclass
class MemoryBus:
    """A `fairlead.wire.bus.Bus` inside one process; single-threaded, synchronous."""

    filter: SampleFilter | None = None
    _subscribers: list[_Entry[SampleHandler]] = field(default_factory=list)
    _queryables: list[_Entry[tuple[str, LaterHandler]]] = field(default_factory=list)
    _tokens: list[_Entry[None]] = field(default_factory=list)
    _watchers: list[_Entry[TokenHandler]] = field(default_factory=list)

    def deliver(self, sample: Sample) -> None:
        """Pass one sample through the filter to every matching subscriber."""
        for out in self.filter(sample) if self.filter else (sample,):
            for entry in list(self._subscribers):
                if matches(entry.key, out.key):
                    entry.handler(out)

    def publisher(self, key: str, kind: type[Message], qos: Qos) -> _MemoryPublisher:
        """A publisher whose every put is delivered before it returns, whatever its ``qos``."""
        return _MemoryPublisher(self, key)

    def subscribe(self, key_expr: str, handler: SampleHandler) -> _Entry[SampleHandler]:
        """Call ``handler`` within every matching put, in the order of subscription."""
        return self._add(self._subscribers, key_expr, dropping(handler))

    def subscribe_frames(self, key: str, handler: SampleHandler) -> _Entry[SampleHandler]:
        """As `subscribe`."""
        return self.subscribe(key, handler)

    def serve(self, key: str, who: str, handler: QueryHandler) -> _Entry[tuple[str, LaterHandler]]:
        """Answer queries on ``key`` with whatever ``handler`` returns or refuses."""
        return self.serve_later(key, who, lambda payload, answer: answer(handler(payload)))

    def serve_later(
        self, key: str, who: str, handler: LaterHandler
    ) -> _Entry[tuple[str, LaterHandler]]:
        """Answer queries on ``key``, before ``handler`` returns or from another thread later."""
        return self._add(self._queryables, key, (who, handler))

    def ask(self, key: str, request: Message, timeout_s: float, on_reply: ReplyHandler) -> None:
        """Call the handler of ``key``; what it answers, now or later, goes to ``on_reply``."""
        payload = encode(request)
        for entry in list(self._queryables):
            if entry.key == key:
                who, handler = entry.handler

                def answer(outcome: Message | Exception, who: str = who) -> None:
                    on_reply(_reply_of(who, outcome))

                try:
                    handler(payload, answer)
                except Exception as error:  # noqa: BLE001 - as over the network
                    answer(error)
                return
        on_reply(no_answer(key, None))

    def query(self, key: str, request: Message, timeout_s: float) -> bytes:
        """Call the handler of ``key`` and return its encoded reply.

        Raises:
            RefusedError: the handler raised.
            NoAnswerError: nobody serves ``key``, or answers within ``timeout_s``.
        """
        return wait_for_reply(self, key, request, timeout_s)

    def declare_token(self, key: str) -> _Entry[None]:
        """Announce a token to those who watch, until it is taken back."""
        self._announce(key, True)
        entry = self._add(self._tokens, key, None)
        entry.on_undeclare = lambda: self._announce(key, False)
        return entry

    def watch_tokens(self, key_expr: str, handler: TokenHandler) -> _Entry[TokenHandler]:
        """Call ``handler`` for the tokens there are, then within each change."""
        for token in self._tokens:
            if matches(key_expr, token.key):
                handler(token.key, True)
        return self._add(self._watchers, key_expr, handler)

    def close(self) -> None:
        """Take back every token (watchers are told), then all handlers."""
        for token in list(self._tokens):
            token.undeclare()
        self._subscribers.clear()
        self._queryables.clear()
        self._watchers.clear()

    def _announce(self, key: str, alive: bool) -> None:
        for watcher in list(self._watchers):
            if matches(watcher.key, key):
                watcher.handler(key, alive)

    @staticmethod
    def _add(registry: list[_Entry[Handler]], key: str, handler: Handler) -> _Entry[Handler]:
        entry = _Entry(registry, key, handler)
        registry.append(entry)
        return entry


def _reply_of(who: str, outcome: Message | Exception) -> bytes | FairleadError:
    if isinstance(outcome, Exception):
        return error_of(refusal_of(who, outcome))
    return encode(outcome)
