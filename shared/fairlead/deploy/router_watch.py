"""What a client of a router says while it waits for it, and when it is lost and found."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable

from fairlead.errors import ConfigError, TransportError
from fairlead.wire.endpoints import LINK_SILENCE_S, Endpoints
from fairlead.wire.on_loop import open_session
from fairlead.wire.session import ZenohBus

CHECK_S = 0.25
REMIND_S = 20.0
"""While it waits, a service says so again this often."""


async def open_patiently(
    endpoints: Endpoints, on_wait: Callable[[TransportError], None]
) -> ZenohBus:
    """Open a session; a client's is tried until its router is reached.

    Args:
        on_wait: called after each attempt in vain.

    Raises:
        TransportError: a peer's or router's session cannot be opened.
    """
    while True:
        try:
            return await open_session(endpoints)
        except TransportError as error:
            if endpoints.mode != "client":
                raise
            on_wait(error)


async def open_with_logging(endpoints: Endpoints, log: logging.Logger) -> ZenohBus:
    """Open a service's session; a client waits for its router, and says so."""
    due_s = 0.0

    def on_wait(error: TransportError) -> None:
        nonlocal due_s
        if time.monotonic() >= due_s:
            log.warning("waiting: %s", error)
            due_s = time.monotonic() + REMIND_S

    return await open_patiently(endpoints, on_wait)


async def refuse_duplicate_service(service: str, bus: ZenohBus, token: str) -> None:
    """Make sure that no process of this name is alive behind the same router.

    The token of a process that died with its host stays until its link has been silent
    for long enough; so it gets that time to go.

    Raises:
        ConfigError: if it stays.
    """
    deadline = time.monotonic() + 2.0 * LINK_SILENCE_S
    while await asyncio.to_thread(bus.is_declared, token):
        if time.monotonic() > deadline:
            raise ConfigError(
                f"{service}: another {service} of this robot is alive behind the same router, "
                "perhaps on another host; end that one first: fairlead ps, fairlead down there"
            )
        await asyncio.sleep(CHECK_S)


async def watch_router(bus: ZenohBus, where: str, log: logging.Logger) -> None:
    """Say in the log when the router is lost and when it is back, until cancelled.

    The session reconnects by itself; what it means for the robot is not decided here.
    """
    linked = True
    while True:
        await asyncio.sleep(CHECK_S)
        if bus.has_router != linked:
            linked = not linked
            if linked:
                log.info("the router %s is back", where)
            else:
                log.warning("lost the router %s; connecting again until it is back", where)
