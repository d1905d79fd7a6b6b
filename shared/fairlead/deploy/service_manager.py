"""What systemd is told that started this process with ``Type=notify``: sd_notify(3)'s datagrams."""

from __future__ import annotations

import asyncio
import os
import socket
from contextlib import suppress

NOTIFY_VARIABLE = "NOTIFY_SOCKET"
"""Set for whoever systemd, or the like, started and watches."""
TIMES_PER_WATCHDOG = 4


def say_ready() -> None:
    """The service has started. Nobody is told where no service manager asked for it."""
    _tell(b"READY=1")


class Pulse:
    """Whether a thread goes on whose standstill the service's event loop would not notice."""

    def __init__(self) -> None:
        self._rests = True
        self._beat = False

    def beat(self) -> None:
        """It goes on, and soon says so again."""
        self._beat, self._rests = True, False

    def rest(self) -> None:
        """What it does now may take long: nothing is expected until it beats again."""
        self._rests = True

    def goes_on(self) -> bool:
        """Whether it rests, or has beaten since this was asked before."""
        beat, self._beat = self._beat, False
        return self._rests or beat


async def say_alive(pulse: Pulse | None = None) -> None:
    """Until it is cancelled: as long as this event loop and the pulse go on, systemd ends nothing.

    Each is to go on within a quarter of the time that systemd waits.
    """
    watchdog_us = os.environ.get("WATCHDOG_USEC", "")
    if not (watchdog_us.isascii() and watchdog_us.isdigit()) or int(watchdog_us) == 0:
        return
    while True:
        if pulse is None or pulse.goes_on():
            _tell(b"WATCHDOG=1")
        await asyncio.sleep(int(watchdog_us) * 1e-6 / TIMES_PER_WATCHDOG)


def _tell(state: bytes) -> None:
    address = os.environ.get(NOTIFY_VARIABLE, "")
    if not address:
        return
    if address.startswith("@"):  # a name that is no file
        address = f"\0{address[1:]}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager, suppress(OSError):
        manager.setblocking(False)
        manager.sendto(state, address)
