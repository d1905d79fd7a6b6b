"""Links whose other end is gone: closing one does not hold up the others, or take for ever."""

from __future__ import annotations

import asyncio
import socket
import struct
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from fairlead.wire.endpoints import LINK_SILENCE_S

PERIOD_S = 0.25
"""Shorter than the times after which Zenoh gives a link up: it is seen before it is closed."""
_OFF = struct.pack("ii", 0, 0)


async def forbid_lingering(*ports: int) -> None:
    """Until cancelled, keep every link to or from these ports from blocking while it is closed.

    Zenoh closes a link in a thread that serves other links too, and has the kernel block it there
    for up to 10 s while something was not sent. The kernel goes on sending without that. A link
    with TLS Zenoh keeps, with all that was declared over it, until what it wrote was taken: for
    15 minutes on a dead network, if the kernel does not give up earlier.
    """
    while True:
        with suppress(OSError):  # no descriptor is left to list them with
            _stop_lingering(ports)
        await asyncio.sleep(PERIOD_S)


def _stop_lingering(ports: Collection[int]) -> None:
    for descriptor in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # a file, one that listens, or closed meanwhile
            theirs = socket.socket(fileno=int(descriptor.name))
            try:
                if _is_link(theirs, ports):
                    silence_ms = int(1000 * LINK_SILENCE_S)
                    theirs.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _OFF)
                    theirs.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, silence_ms)
            finally:
                theirs.detach()


def _is_link(one: socket.socket, ports: Collection[int]) -> bool:
    if one.family not in (socket.AF_INET, socket.AF_INET6):
        return False
    return one.getsockname()[1] in ports or one.getpeername()[1] in ports
