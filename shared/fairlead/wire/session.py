"""The Zenoh session every Python service uses: one place that imports zenoh."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import zenoh

from fairlead.errors import FairleadError, TransportError
from fairlead.messages import Message, encode, encoding_of
from fairlead.wire.bus import (
    LaterHandler,
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
from fairlead.wire.cannot_open import no_router, no_session
from fairlead.wire.dropped import dropping
from fairlead.wire.refusal import error_from, refusal_of

_PRIORITY = {
    Qos.HOT: zenoh.Priority.REAL_TIME,
    Qos.CAMERA: zenoh.Priority.DATA_LOW,
    Qos.STATUS: zenoh.Priority.DATA,
}


LINK_SILENCE_S = 2.0  # < ANSWER_TIMEOUT_S of the client, which says why
"""Behind a router a link that was silent for so long is closed, with what was declared
over it, and made anew. Never a watchdog: motion ends far earlier, by leases and heartbeats."""

RUNTIME_VARIABLE = "ZENOH_RUNTIME"
RUNTIME = {
    "peer": "(acc: (worker_threads: 16))",
    "client": "(rx: (worker_threads: 8))",
    "router": "(acc: (worker_threads: 16))",
}
"""Zenoh closes a dead TCP link in one of its receive threads, of which there are usually two, and
waits there up to 10 s for what was not sent; not in a router (`fairlead.wire.lingering`).
A connection that never said anything it closes where it accepts, which takes 4 ms; with the usual
one thread there nothing is read meanwhile of the links that this session dialled."""

ACCEPT_PENDING = 10_000
"""Connections that say nothing are let wait for LINK_SILENCE_S. Beyond its own 100 of them Zenoh
turns each away at once, at the cost of 4 ms in which the session receives nothing: 1,000 idle
connections made a service deaf for seconds."""

ROUTER_PATIENCE_S = 2.0
"""How long one attempt to reach a router takes."""


@dataclass(frozen=True)
class Endpoints:
    """Where a session listens and whom it connects to.

    Peers do not forward for each other, so on one host every pair of services has a
    link: each service listens on its own fixed port and connects to those listed.

    Args:
        listen: endpoints such as ``tcp/127.0.0.1:7501``; empty for tools and clients.
        connect: a peer's: tried for ever, in the background; a client's: its router.
        mode: ``peer``, ``client`` (of a router) or ``router``.
        router_host: a client's: the name of the host where its router runs.
        access: a part of a Zenoh configuration, with a password: who it is, what it lets through.
    """

    listen: Sequence[str] = ()
    connect: Sequence[str] = ()
    mode: str = "peer"
    router_host: str = ""
    access: Mapping[str, Any] = field(default_factory=dict, repr=False)

    def config(self) -> dict[str, Any]:
        """The Zenoh configuration: static endpoints, no multicast, endless reconnect."""
        config = {
            "mode": self.mode,
            "listen": {"endpoints": list(self.listen), "exit_on_failure": True},
            "connect": {
                "endpoints": list(self.connect),
                "timeout_ms": self._connect_timeout_ms(),
                "exit_on_failure": False,
                "retry": {
                    "period_init_ms": 50,
                    "period_max_ms": 500,
                    "period_increase_factor": 2,
                },
            },
            "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
            "timestamping": {"enabled": False},
            "adminspace": {"enabled": False},
        }
        transport = {**self._transport(), **self.access.get("transport", {})}
        return {**config, **self.access, "transport": transport}

    def _connect_timeout_ms(self) -> int:
        if self.mode == "client":
            return int(1000 * ROUTER_PATIENCE_S)
        return -1 if self.connect else 0

    def _transport(self) -> dict[str, Any]:
        # An express message takes a whole batch; a burst of one tick (transforms, task,
        # joints) must find room, or its last messages are dropped.
        queue: dict[str, Any] = {"size": {"real_time": 16}}
        silence_ms = int(1000 * LINK_SILENCE_S)
        unicast = {"accept_timeout": silence_ms, "accept_pending": ACCEPT_PENDING}
        if self.mode == "peer":
            return {"link": {"tx": {"queue": queue}}, "unicast": unicast}
        if self.mode == "router":
            # A client that takes nothing any more is cut off before the others notice: what
            # must not be dropped (declarations, answers) would else wait for it for 5 s.
            queue["congestion_control"] = {"block": {"wait_before_close": 500_000}}  # us
        return {
            "link": {"tx": {"queue": queue, "lease": silence_ms, "keep_alive": 4}},
            "unicast": {**unicast, "open_timeout": silence_ms},
        }


class _ZenohPublisher:
    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher

    def put(self, message: Message) -> None:
        self.put_bytes(encode(message))

    def put_bytes(self, payload: bytes, attachment: bytes | None = None) -> None:
        self._publisher.put(payload, attachment=attachment)


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
        # Read when the process opens its first session.
        os.environ.setdefault(RUNTIME_VARIABLE, RUNTIME[endpoints.mode])
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(endpoints.config())))
        except zenoh.ZError as error:
            connect = endpoints.connect
            if endpoints.mode == "client":
                raise no_router(connect, endpoints.router_host, ROUTER_PATIENCE_S) from None
            raise no_session(endpoints.listen, connect, error) from None
        # Zenoh takes tokens and token watchers back as soon as nobody refers to them.
        self._kept: list[Undeclare] = []

    def publisher(self, key: str, kind: type[Message], qos: Qos) -> _ZenohPublisher:
        """Declare a key; hot ones are express at real-time priority. All drop rather than wait."""
        return _ZenohPublisher(
            self._session.declare_publisher(
                key,
                encoding=zenoh.Encoding(encoding_of(kind)),
                congestion_control=zenoh.CongestionControl.DROP,
                priority=_PRIORITY[qos],
                express=qos is Qos.HOT,
            )
        )

    def foreign_publisher(self, key: str) -> _ZenohPublisher:
        """Declare a key of another system: bytes in its format, sent as hot messages are."""
        return _ZenohPublisher(
            self._session.declare_publisher(
                key, congestion_control=zenoh.CongestionControl.DROP, express=True
            )
        )

    def subscribe(self, key_expr: str, handler: SampleHandler) -> Undeclare:
        """Call ``handler`` in Zenoh's receive thread, in the order of arrival."""
        take = dropping(handler)

        def on_sample(sample: zenoh.Sample) -> None:
            if sample.kind == zenoh.SampleKind.PUT:
                take(Sample(str(sample.key_expr), sample.payload.to_bytes()))

        # In Zenoh's own receive thread: a thread per subscriber (the default) would let one
        # key's messages overtake another's, and joints must come after their transforms.
        direct = zenoh.handlers.Callback(on_sample, indirect=False)
        return self._session.declare_subscriber(key_expr, direct)

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
            once(no_answer(key, timeout_s))

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
    def has_router(self) -> bool:
        """Whether there is a link to a router now."""
        return bool(list(self._session.info.routers_zid()))

    def _keep(self, declared: Undeclare) -> Undeclare:
        self._kept.append(declared)
        return declared

    def close(self) -> None:
        """End the session; everything declared goes with it."""
        self._session.close()  # type: ignore[no-untyped-call]


def _reply(query: zenoh.Query, key: str, who: str, outcome: Message | Exception) -> None:
    with query:  # leaving it says that no more replies come
        if not isinstance(outcome, Exception):
            try:
                query.reply(key, encode(outcome))
                return
            except (TypeError, ValueError, OverflowError) as error:  # no message after all
                outcome = error
        query.reply_err(encode(refusal_of(who, outcome)))
