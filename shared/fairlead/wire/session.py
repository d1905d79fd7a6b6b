"""The Zenoh session every Python service uses: one place that imports zenoh."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import zenoh

from fairlead.errors import FairleadError, MessageError, TransportError
from fairlead.messages import Message, encode, encoding_of
from fairlead.wire.bus import (
    LaterHandler,
    Publisher,
    Qos,
    QueryHandler,
    ReplyHandler,
    Sample,
    SampleHandler,
    TokenHandler,
    Undeclare,
    no_answer,
    wait_for_reply,
)
from fairlead.wire.endpoints import ROUTER_PATIENCE_S, RUNTIME, RUNTIME_VARIABLE, Endpoints
from fairlead.wire.failures import dropping, error_from, no_router, no_session, refusal_of
from fairlead.wire.frame_route import FramePublisher, FrameSubscription
from fairlead.wire.frame_thread import FrameThread

_PRIORITY = {
    Qos.HOT: zenoh.Priority.REAL_TIME,
    Qos.CAMERA: zenoh.Priority.DATA_LOW,
    Qos.STATUS: zenoh.Priority.DATA,
}

CLOSE_WAIT_S = 1.0
MOST_NAMED_KEYS = 64


class _ZenohPublisher:
    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher

    def put(self, message: Message) -> None:
        self.put_bytes(encode(message))

    def put_bytes(self, payload: bytes, attachment: bytes | None = None) -> None:
        self._publisher.put(payload, attachment=attachment)


class _Subscription:
    """A subscription; of a wildcard also each key that was heard, by its name.

    Zenoh numbers a key that a subscriber names, and looks up once who may write and read it. On one
    that only a wildcard matches it spells the key out and asks all rules at each message.
    """

    def __init__(self, session: zenoh.Session, key_expr: str, take: SampleHandler) -> None:
        self._session, self._take = session, take
        self._named: dict[str, Undeclare] = {}
        self._is_open = True
        on_sample = self._on_named if "*" in key_expr else self._on_sample
        # In Zenoh's own receive thread: a thread per subscriber (the default) would let one
        # key's messages overtake another's, and joints must come after their transforms.
        direct = zenoh.handlers.Callback(on_sample, indirect=False)
        self._subscriber: Undeclare = session.declare_subscriber(key_expr, direct)

    def _on_sample(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._take(Sample(str(sample.key_expr), sample.payload.to_bytes()))

    def _on_named(self, sample: zenoh.Sample) -> None:
        self._on_sample(sample)
        key = str(sample.key_expr)
        if key not in self._named and len(self._named) < MOST_NAMED_KEYS:
            unread: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(1)
            with suppress(zenoh.ZError):  # the session is closing
                self._named[key] = self._session.declare_subscriber(key, unread)
            if not self._is_open:
                self._undeclare_named()

    def undeclare(self) -> None:
        """Take it back."""
        self._subscriber.undeclare()
        self._is_open = False
        self._undeclare_named()

    def _undeclare_named(self) -> None:
        for key in list(self._named):
            if named := self._named.pop(key, None):
                named.undeclare()


class _Wanted:
    """Whether anybody is subscribed to a key: Zenoh says so, as asking takes as long as sending."""

    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._is_so = False
        direct = zenoh.handlers.Callback(self._on_status, indirect=False)  # as for tokens
        self._listener = publisher.declare_matching_listener(direct)
        status: Any = publisher.matching_status  # its stub has a bool
        if status.matching:  # else what the listener was told meanwhile counts
            self._is_so = True

    def __call__(self) -> bool:
        return self._is_so

    def _on_status(self, status: zenoh.MatchingStatus) -> None:
        self._is_so = status.matching


@contextmanager
def _threads_of(mode: str) -> Iterator[None]:
    """What is read when a process opens its first session; not for those that it starts."""
    if RUNTIME_VARIABLE in os.environ:
        yield
        return
    os.environ[RUNTIME_VARIABLE] = RUNTIME[mode]
    try:
        yield
    finally:
        os.environ.pop(RUNTIME_VARIABLE, None)


class ZenohBus:
    """A `fairlead.wire.bus.Bus` over one Zenoh session.

    Raises:
        TransportError: if the session cannot be opened, naming the endpoints (a peer's, most
            often: the listening port is taken; a client's: its router cannot be reached).
    """

    def __init__(self, endpoints: Endpoints) -> None:
        # Logged as errors there, and by all we have seen neither is one: a sample under way
        # while its link closes, and a sample that overtakes the declaration of its key in a
        # session that is just joining ("unknown expr_id"); ticks repair what is dropped. Whoever is
        # refused by those it dials would say so twice a second. RUST_LOG brings the lines back.
        zenoh.init_log_from_env_or(
            "error,zenoh::api::session=off,zenoh_transport::unicast::establishment=off"
        )
        try:
            with _threads_of(endpoints.mode):
                self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(endpoints.config())))
        except zenoh.ZError as error:
            connect = endpoints.connect
            if endpoints.mode == "client":
                raise no_router(connect, endpoints.router_host, ROUTER_PATIENCE_S) from None
            raise no_session(endpoints.listen, connect, error) from None
        # Zenoh takes tokens and token watchers back as soon as nobody refers to them.
        self._kept: list[Undeclare] = []
        self._frames: list[FramePublisher | FrameSubscription] = []
        self._frame_thread = FrameThread()

    def publisher(self, key: str, kind: type[Message], qos: Qos) -> Publisher:
        """Declare a key; hot ones are express at real-time priority. All drop rather than wait."""
        declared = self._session.declare_publisher(
            key,
            encoding=zenoh.Encoding(encoding_of(kind)),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=_PRIORITY[qos],
            express=qos is Qos.HOT,
        )
        ordinary = _ZenohPublisher(declared)
        if qos is not Qos.CAMERA:
            return ordinary
        self._frames.append(frames := FramePublisher(self, key, ordinary, _Wanted(declared)))
        return frames

    def foreign_publisher(self, key: str) -> _ZenohPublisher:
        """Declare a key of another system: bytes in its format, sent as hot messages are."""
        return _ZenohPublisher(
            self._session.declare_publisher(
                key, congestion_control=zenoh.CongestionControl.DROP, express=True
            )
        )

    def subscribe(self, key_expr: str, handler: SampleHandler) -> Undeclare:
        """Call ``handler`` in Zenoh's receive thread, in the order of arrival."""
        return _Subscription(self._session, key_expr, dropping(handler))

    def subscribe_frames(self, key: str, handler: SampleHandler) -> Undeclare:
        """Through shared memory where the camera is on this host."""
        self._frames.append(frames := FrameSubscription(self, key, handler, self._frame_thread))
        return frames

    def serve(self, key: str, who: str, handler: QueryHandler) -> Undeclare:
        """Answer queries on ``key`` on Zenoh's threads; what is raised becomes a `Refusal`."""
        return self.serve_later(key, who, lambda payload, answer: answer(handler(payload)))

    def serve_later(self, key: str, who: str, handler: LaterHandler) -> Undeclare:
        """Answer queries on ``key`` whenever ``handler`` calls the function it is given."""

        def on_query(query: zenoh.Query) -> None:
            def answer(outcome: Message | Exception) -> None:
                _reply(query, key, who, outcome)

            payload = query.payload.to_bytes() if query.payload is not None else b""
            try:
                handler(payload, answer)
            except Exception as error:  # noqa: BLE001 - else a bug would read as "no answer"
                answer(error)

        return self._session.declare_queryable(key, on_query)

    def ask(self, key: str, request: Message, timeout_s: float, on_reply: ReplyHandler) -> None:
        """Ask; ``on_reply`` is called once, on one of Zenoh's threads: it must not block.

        Raises:
            TransportError: the session has closed.
        """
        waiting = [on_reply]

        def once(reply: bytes | FairleadError) -> None:
            if waiting:
                waiting.pop()(reply)

        def on_zenoh(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                once(reply.ok.payload.to_bytes())
            elif reply.err is not None:
                once(error_from(key, reply.err.payload.to_bytes(), timeout_s))

        def on_end() -> None:  # no more replies come; most often because one has
            once(no_answer(key, None))

        direct = zenoh.handlers.Callback(on_zenoh, on_end, indirect=False)
        try:
            self._session.get(key, direct, payload=encode(request), timeout=timeout_s)
        except zenoh.ZError as error:
            raise TransportError(f"{key}: cannot ask: {error}") from None

    def query(self, key: str, request: Message, timeout_s: float) -> bytes:
        """Ask and wait for the first reply; a session that has closed is a `TransportError`."""
        return wait_for_reply(self, key, request, timeout_s)

    def declare_token(self, key: str) -> Undeclare:
        """Announce a token that ends with the session, or when its process dies."""
        return self._keep(self._session.liveliness().declare_token(key))

    def watch_tokens(self, key_expr: str, handler: TokenHandler) -> Undeclare:
        """Call ``handler`` on Zenoh's threads for each token alive now and each change."""

        def on_token(sample: zenoh.Sample) -> None:
            handler(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        # A thread of its own (the default) would be a daemon where the caller's is one: it wakes
        # up after the session has closed, and aborts a process that is just ending.
        direct = zenoh.handlers.Callback(on_token, indirect=False)
        return self._keep(
            self._session.liveliness().declare_subscriber(key_expr, direct, history=True)
        )

    def is_declared(self, token: str) -> bool:
        """Whether somebody has declared this liveliness token."""
        replies = self._session.liveliness().get(token, timeout=ROUTER_PATIENCE_S)
        return any(reply.ok is not None for reply in replies)

    @property
    def zid(self) -> str:
        """The session's id, as Zenoh writes it: hexadecimal."""
        return str(self._session.zid())

    @property
    def peers(self) -> set[str]:
        """Ids of the sessions that there is a link to now."""
        return {str(zid) for zid in self._session.info.peers_zid()}

    @property
    def has_router(self) -> bool:
        """Whether there is a link to a router now."""
        return bool(list(self._session.info.routers_zid()))

    def _keep(self, declared: Undeclare) -> Undeclare:
        self._kept.append(declared)
        return declared

    def close(self) -> None:
        """End the session and what it declared; Zenoh would wait 10 s for a paused peer."""
        for frames in self._frames:
            frames.close()
        closing = threading.Thread(target=self._session.close, name="close", daemon=True)
        closing.start()
        closing.join(CLOSE_WAIT_S)


def _reply(query: zenoh.Query, key: str, who: str, outcome: Message | Exception) -> None:
    with query:  # leaving it says that no more replies come
        if not isinstance(outcome, Exception):
            try:
                query.reply(key, encode(outcome))
                return
            except MessageError as error:
                outcome = error
        query.reply_err(encode(refusal_of(who, outcome)))
