"""Where a Zenoh session listens and connects, and how it is configured for that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

LINK_SILENCE_S = 2.0  # < ANSWER_TIMEOUT_S of the client, which says why
"""Behind a router a link that was silent for so long is closed, with what was declared
over it, and made anew. Never a watchdog: motion ends far earlier, by leases and heartbeats."""

RUNTIME_VARIABLE = "ZENOH_RUNTIME"
RUNTIME = {
    "peer": "(acc: (worker_threads: 16), rx: (handover: acc), tx: (handover: acc), "
    "net: (handover: acc))",
    "client": "(rx: (worker_threads: 1), tx: (handover: rx))",
    "router": "(acc: (worker_threads: 16), rx: (worker_threads: 1), tx: (handover: rx))",
}
"""Of a TLS link Zenoh 1.10 reads and writes one state without a lock, from two threads: memory was
broken and a gate aborted (its issue 2557). So one thread does both where links have TLS; the mode
of the first session that a process opens counts. Zenoh closes a dead link there, too, and waits up
to 10 s for what was not sent: not in Python's services and router (`fairlead.wire.lingering`).
A peer has one pool of threads for everything: what a thread has read it also hands on. In pools
of their own, as is usual, each message wakes two or three threads of each process that gets it, in
turn; where cores are few a tick waited for that a quarter of a millisecond longer. A connection
that never said anything Zenoh closes in this pool, which takes 4 ms: so it is a large one."""

ACCEPT_PENDING = 10_000
"""Connections that say nothing are let wait for LINK_SILENCE_S. Beyond its own 100 of them Zenoh
turns each away at once, at the cost of 4 ms in which the session receives nothing: 1,000 idle
connections made a service deaf for seconds."""

MESSAGE_MAX = 80_000_000
"""Bytes, more than any picture has. Zenoh's own 1 GB it would put together for whoever has a link,
on any key: it knows that key only then."""

RX = {"max_message_size": MESSAGE_MAX}

DROPPED = [
    {
        "messages": ["put", "delete", "query"],
        "flows": ["ingress"],
        "key_exprs": ["**"],
        "overwrite": {"congestion_control": "drop"},
    }
]
"""A router drops these where a link has no room. Its one thread would else wait for room that only
it can make; after 500 ms in which nobody hears anything, the receiver's link was closed."""

ROUTER_PATIENCE_S = 2.0
"""How long one attempt to reach a router takes."""


@dataclass(frozen=True)
class Endpoints:
    """Where a session listens and whom it connects to.

    Peers do not forward for each other, so on one host every pair of services has a
    link: each service listens on its own socket and connects to those listed.

    Args:
        listen: endpoints such as ``unixsock-stream//folder/hal``; empty for tools and clients.
        connect: a peer's: tried for ever, in the background; a client's: its router.
        mode: ``peer``, ``client`` (of a router) or ``router``.
        router_host: a client's: the name of the host where its router runs.
        access: a part of a Zenoh configuration, with a password or the files of a certificate: who
            it is, what it lets through.
    """

    listen: Sequence[str] = ()
    connect: Sequence[str] = ()
    mode: str = "peer"
    router_host: str = ""
    access: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @property
    def part(self) -> dict[str, Any]:
        """What a session that is not opened in Python gets of its configuration, with `access`."""
        return _merged({"transport": {"link": {"rx": RX}}}, self.access)

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
        if self.mode == "router":
            config["qos"] = {"network": DROPPED}
        return _merged(config | {"transport": self._transport()}, self.access)

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
            return {"link": {"tx": {"queue": queue}, "rx": RX}, "unicast": unicast}
        if self.mode == "router":
            # A client that takes nothing any more is cut off before the others notice: what
            # must not be dropped (declarations, answers) would else wait for it for 5 s.
            queue["congestion_control"] = {"block": {"wait_before_close": 500_000}}  # us
        return {
            "link": {"tx": {"queue": queue, "lease": silence_ms, "keep_alive": 4}, "rx": RX},
            "unicast": {**unicast, "open_timeout": silence_ms},
        }


def _merged(config: Mapping[str, Any], part: Mapping[str, Any]) -> dict[str, Any]:
    """Both; where both have a value, that of ``part``."""
    both = {
        key: _merged(config[key], value) if isinstance(value, Mapping) and key in config else value
        for key, value in part.items()
    }
    return {**config, **both}
