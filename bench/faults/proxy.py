"""A bad network between a Zenoh client and its router: TCP, message by message.

Zenoh sends batches over TCP, each behind its length (two bytes, little endian). An express
message has a batch of its own, so what is lost, late or doubled here is single messages; only what
the gate says in one step goes together. The
rules change while the connection lives; nobody is told. The kernel needs no ``netem``.

Zenoh numbers its frames: a doubled batch, or one overtaken by a later one, is dropped by the
receiver, so reordering acts as loss.

The threads that pass messages on have a higher priority than the robot's processes, where this
machine permits it: a busy machine must not be taken for a bad network.
"""

from __future__ import annotations

import errno
import heapq
import itertools
import os
import random
import socket
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import IO, Literal

Direction = Literal["up", "down"]
"""``up``: from the client to the router."""

Delivery = tuple[float, bytes]
"""When a batch goes on (time.monotonic; 0: at once), and its bytes without the length."""

Rule = Callable[[bytes], Sequence[Delivery]]
"""What becomes of one batch."""

PRIORITY, SWITCH_S = -10, 0.0005
SMALL = 16
"""Batches up to this size are keep-alives and acknowledgements."""


def forward(batch: bytes) -> Sequence[Delivery]:
    """A good network."""
    return ((0.0, batch),)


def drop(batch: bytes) -> Sequence[Delivery]:
    """One half of a partition, or of a half-open connection."""
    return ()


def loses(share: float, rng: random.Random) -> Rule:
    """Each batch is lost with a probability."""
    return lambda batch: () if rng.random() < share else forward(batch)


def delays(seconds: float, spread_s: float, rng: random.Random) -> Rule:
    """Each batch is late by ``seconds`` +- ``spread_s``, so some overtake others."""

    def rule(batch: bytes) -> Sequence[Delivery]:
        return ((time.monotonic() + seconds + rng.uniform(-spread_s, spread_s), batch),)

    return rule


def doubles(batch: bytes) -> Sequence[Delivery]:
    """Each batch arrives twice."""
    return ((0.0, batch), (0.0, batch))


def swaps() -> Rule:
    """Each second batch goes on before the one before it."""
    kept: list[bytes] = []

    def rule(batch: bytes) -> Sequence[Delivery]:
        if not kept:
            kept.append(batch)
            return ()
        return ((0.0, batch), (0.0, kept.pop()))

    return rule


def lossy(lost: float, overtaken: float, rng: random.Random) -> Rule:
    """Some batches are lost, and some come after the one that follows them."""
    kept: list[bytes] = []

    def rule(batch: bytes) -> Sequence[Delivery]:
        if rng.random() < lost:
            return ()
        if not kept and rng.random() < overtaken:
            kept.append(batch)
            return ()
        late = [(0.0, kept.pop())] if kept else []
        return ((0.0, batch), *late)

    return rule


def stalls(seconds: float) -> Rule:
    """Nothing goes on for ``seconds`` from now on; then all of it, in order."""
    until = time.monotonic() + seconds
    return lambda batch: ((until, batch),)


def gap(seconds: float) -> Rule:
    """What comes in the next ``seconds`` is lost."""
    until = time.monotonic() + seconds
    return lambda batch: () if time.monotonic() < until else forward(batch)


def corrupts(share: float, rng: random.Random) -> Rule:
    """One bit of some batches is wrong."""

    def rule(batch: bytes) -> Sequence[Delivery]:
        if rng.random() >= share or not batch:
            return forward(batch)
        changed = bytearray(batch)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        return forward(bytes(changed))

    return rule


def keeps_every(nth: int) -> Rule:
    """All but each nth of the batches that carry something are lost, the first ones first."""
    counter = itertools.count(1)

    def rule(batch: bytes) -> Sequence[Delivery]:
        if len(batch) <= SMALL or next(counter) % nth == 0:
            return forward(batch)
        return ()

    return rule


@dataclass(frozen=True)
class _Rules:
    """The rule for links older than ``since`` (time.monotonic), and for those made later."""

    since: float
    old_links: Rule
    new_links: Rule


class FaultProxy:
    """Listens on a port of its own and passes connections on to another port."""

    def __init__(self, to_port: int) -> None:
        self._rules: dict[Direction, _Rules] = {}
        self.both(forward)
        self._to_port = to_port
        sys.setswitchinterval(SWITCH_S)
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._server.getsockname()[1])
        self._sockets: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> FaultProxy:
        return self

    def __exit__(self, *_: object) -> None:
        for one in (self._server, *self._sockets):
            _close(one)

    def both(self, rule: Rule) -> int:
        """The same rule in both directions.

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        self.set("up", rule)
        self.set("down", rule)
        return now_ns

    def set(self, direction: Direction, rule: Rule, new_links: Rule | None = None) -> int:
        """A rule for one direction; when, as `both`.

        Args:
            new_links: the rule for links made from now on, if not the same. One that loses
                single messages is not for them: no network loses what a session declares when
                its link begins, for TCP sends it again, and without it the client stays mute.
        """
        now_ns = time.monotonic_ns()
        self._rules[direction] = _Rules(time.monotonic(), rule, new_links or rule)
        return now_ns

    def rule(self, direction: Direction, made: float) -> Rule:
        """What holds for a link made then (time.monotonic)."""
        rules = self._rules[direction]
        return rules.old_links if made < rules.since else rules.new_links

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._server.accept()
            except OSError:  # closed
                return
            try:
                router = socket.create_connection(("127.0.0.1", self._to_port))
            except OSError:  # no router now: the client tries again
                client.close()
                continue
            self._sockets += [client, router]
            for one in (client, router):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            _Pipe(self, "up", client, router)
            _Pipe(self, "down", router, client)


class _Pipe:
    """One direction of one connection: a thread that reads, and one that sends when due."""

    def __init__(
        self, proxy: FaultProxy, direction: Direction, source: socket.socket, sink: socket.socket
    ) -> None:
        self._proxy, self._direction = proxy, direction
        self._source, self._sink = source, sink
        self._made = time.monotonic()
        self._due: list[tuple[float, int, bytes]] = []
        self._numbers = itertools.count()
        self._changed = threading.Condition()
        self._ended = False
        for work in (self._read, self._send):
            threading.Thread(target=work, daemon=True).start()

    def _read(self) -> None:
        _hurry()
        stream = self._source.makefile("rb")
        try:
            while batch := _next_batch(stream):
                self._pass_on(self._proxy.rule(self._direction, self._made)(batch))
        finally:
            with self._changed:
                self._ended = True
                self._changed.notify()

    def _pass_on(self, deliveries: Sequence[Delivery]) -> None:
        with self._changed:
            for due, batch in deliveries:
                heapq.heappush(self._due, (due, next(self._numbers), batch))
            self._changed.notify()

    def _send(self) -> None:
        _hurry()
        while (batch := self._next()) is not None:
            try:
                self._sink.sendall(len(batch).to_bytes(2, "little") + batch)
            except OSError:
                break
        _close(self._sink)
        _close(self._source)

    def _next(self) -> bytes | None:
        """The batch that is due, once it is; None when the connection has ended."""
        with self._changed:
            while True:
                wait_s = self._due[0][0] - time.monotonic() if self._due else None
                if wait_s is not None and wait_s <= 0:
                    return heapq.heappop(self._due)[2]
                if self._ended and not self._due:
                    return None
                self._changed.wait(wait_s)


def _next_batch(stream: IO[bytes]) -> bytes:
    """Empty at the connection's end."""
    try:
        head = stream.read(2)
        return stream.read(int.from_bytes(head, "little")) if len(head) == 2 else b""
    except OSError as error:
        if error.errno not in (errno.ECONNRESET, errno.EBADF):  # by a process that died; by us
            raise
        return b""


def _hurry() -> None:
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), PRIORITY)


def _close(one: socket.socket) -> None:
    with suppress(OSError):  # not connected any more
        one.shutdown(socket.SHUT_RDWR)
    one.close()
