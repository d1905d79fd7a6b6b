"""The Zenoh session every Python service uses: one place that imports zenoh."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import zenoh

from fairlead.bus import Qos, QueryHandler, Sample, SampleHandler, TokenHandler, Undeclare
from fairlead.errors import FairleadError, MessageError, NoAnswerError, RefusedError, TransportError
from fairlead.messages import Message, Refusal, decode, encode, encoding_of

_PRIORITY = {
    Qos.HOT: zenoh.Priority.REAL_TIME,
    Qos.CAMERA: zenoh.Priority.DATA_LOW,
    Qos.STATUS: zenoh.Priority.DATA,
}


@dataclass(frozen=True)
class Endpoints:
    """Where a session listens and whom it connects to.

    Peers do not forward for each other, so on one host every pair of services has a
    link: each service listens on its own fixed port and connects to those listed.

    Args:
        listen: endpoints such as ``tcp/127.0.0.1:7501``; empty for tools.
        connect: endpoints tried for ever, in the background.
        mode: ``peer``, ``client`` (behind a router) or ``router``.
    """

    listen: Sequence[str] = ()
    connect: Sequence[str] = ()
    mode: str = "peer"

    def config_json(self) -> str:
        """The Zenoh configuration: static endpoints, no multicast, endless reconnect."""
        return json.dumps(
            {
                "mode": self.mode,
                "listen": {"endpoints": list(self.listen), "exit_on_failure": True},
                "connect": {
                    "endpoints": list(self.connect),
                    "timeout_ms": -1 if self.connect else 0,
                    "exit_on_failure": False,
                    "retry": {
                        "period_init_ms": 50,
                        "period_max_ms": 500,
                        "period_increase_factor": 2,
                    },
                },
                "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
                # An express message takes a whole batch; a burst of one tick (transforms, task,
                # joints) must find room, or its last messages are dropped.
                "transport": {"link": {"tx": {"queue": {"size": {"real_time": 16}}}}},
                "timestamping": {"enabled": False},
                "adminspace": {"enabled": False},
            }
        )


class _ZenohPublisher:
    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher

    def put(self, message: Message) -> None:
        self.put_bytes(encode(message))

    def put_bytes(self, payload: bytes) -> None:
        self._publisher.put(payload)


class ZenohBus:
    """A `fairlead.bus.Bus` over one Zenoh session.

    Raises:
        TransportError: if the session cannot be opened, naming the endpoints (most
            often: the listening port is taken by another process).
    """

    def __init__(self, endpoints: Endpoints) -> None:
        # Logged as errors there, and by all we have seen neither is one: a sample under way
        # while its link closes, and a sample that overtakes the declaration of its key in a
        # session that is just joining ("unknown expr_id"); ticks repair what is dropped.
        # RUST_LOG brings the lines back.
        zenoh.init_log_from_env_or("error,zenoh::api::session=off")
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(endpoints.config_json()))
        except zenoh.ZError as error:
            raise TransportError(
                f"zenoh session: cannot open with listen={list(endpoints.listen)} "
                f"connect={list(endpoints.connect)}: {error}; is another process of this "
                "robot still running? see: fairlead ps"
            ) from None
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

    def subscribe(self, key_expr: str, handler: SampleHandler) -> Undeclare:
        """Call ``handler`` in Zenoh's receive thread, in the order of arrival."""

        def on_sample(sample: zenoh.Sample) -> None:
            if sample.kind == zenoh.SampleKind.PUT:
                handler(Sample(str(sample.key_expr), sample.payload.to_bytes()))

        # In Zenoh's own receive thread: a thread per subscriber (the default) would let one
        # key's messages overtake another's, and joints must come after their transforms.
        direct = zenoh.handlers.Callback(on_sample, indirect=False)
        return self._session.declare_subscriber(key_expr, direct)

    def serve(self, key: str, who: str, handler: QueryHandler) -> Undeclare:
        """Answer queries on ``key`` on Zenoh's threads; a `FairleadError` becomes a `Refusal`."""

        def on_query(query: zenoh.Query) -> None:
            payload = query.payload.to_bytes() if query.payload is not None else b""
            with query:
                try:
                    query.reply(key, encode(handler(payload)))
                except RefusedError as error:
                    query.reply_err(encode(Refusal(who=who, reason=error.reason, fix=error.fix)))
                except FairleadError as error:
                    query.reply_err(encode(Refusal(who=who, reason=str(error), fix="")))

        return self._session.declare_queryable(key, on_query)

    def query(self, key: str, request: Message, timeout_s: float) -> bytes:
        """Ask and wait for the first reply.

        Raises:
            RefusedError: the service answered no.
            NoAnswerError: nobody answered within ``timeout_s``, or not in words of ours.
        """
        for reply in self._session.get(key, payload=encode(request), timeout=timeout_s):
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
            assert reply.err is not None
            raise _refusal(key, reply.err.payload.to_bytes())
        raise NoAnswerError(f"{key}: no answer within {timeout_s:g} s; see: fairlead ps")

    def declare_token(self, key: str) -> Undeclare:
        """Announce a token that ends with the session, or when its process dies."""
        return self._keep(self._session.liveliness().declare_token(key))

    def watch_tokens(self, key_expr: str, handler: TokenHandler) -> Undeclare:
        """Call ``handler`` on Zenoh's threads for each token alive now and each change."""

        def on_token(sample: zenoh.Sample) -> None:
            handler(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        return self._keep(
            self._session.liveliness().declare_subscriber(key_expr, on_token, history=True)
        )

    def _keep(self, declared: Undeclare) -> Undeclare:
        self._kept.append(declared)
        return declared

    def close(self) -> None:
        """End the session; everything declared goes with it."""
        self._session.close()  # type: ignore[no-untyped-call]


def _refusal(key: str, payload: bytes) -> FairleadError:
    try:
        refusal = decode(Refusal, payload)
    except MessageError:
        return NoAnswerError(f"{key}: {payload.decode(errors='replace')}")
    return RefusedError(refusal.who, refusal.reason, refusal.fix)
