"""Links whose other end is gone: closing one does not hold up the others."""

from __future__ import annotations

import asyncio
import socket
import struct
from contextlib import suppress
from pathlib import Path

PERIOD_S = 0.25
"""Shorter than the times after which Zenoh gives a link up: it is seen before it is closed."""
_OFF = struct.pack("ii", 0, 0)


async def forbid_lingering() -> None:
    """Until cancelled, keep every socket of this process from blocking in ``close()``.

    Zenoh closes a link in a thread that serves other links too, and has the kernel block it there
    for up to 10 s while something was not sent. The kernel goes on sending without that.
    """
    while True:
        with suppress(OSError):  # no descriptor is left to list them with
            _stop_lingering()
        await asyncio.sleep(PERIOD_S)


def _stop_lingering() -> None:
    for descriptor in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # a file, or closed meanwhile
            theirs = socket.socket(fileno=int(descriptor.name))
            try:
                theirs.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _OFF)
            finally:
                theirs.detach()
