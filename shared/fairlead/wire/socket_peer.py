"""Who is at the other end of a Unix socket: the kernel says it, and nobody need answer."""

from __future__ import annotations

import socket
import struct
from typing import NamedTuple

_UCRED = struct.Struct("=3i")  # process, user, group


class Peer(NamedTuple):
    """A process and its user."""

    process: int
    user: int


def peer_of(link: socket.socket) -> Peer:
    """Of a connected socket."""
    found = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _UCRED.size)
    process, user, _ = _UCRED.unpack(found)
    return Peer(process, user)


def listener_at(path: str) -> Peer:
    """Who listens at a path, or behind a name that begins with NUL.

    Raises:
        OSError: of ``connect``; BlockingIOError where so many wait that nobody else may.
    """
    with socket.socket(socket.AF_UNIX) as asking:
        asking.setblocking(False)
        asking.connect(path)
        return peer_of(asking)
