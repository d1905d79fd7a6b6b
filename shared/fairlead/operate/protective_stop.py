"""A protective stop, requested until the gate is seen to hold it."""

from __future__ import annotations

import secrets
import time

from fairlead.errors import NoAnswerError
from fairlead.messages import Lease, StopLevel
from fairlead.operate.changes import Changes
from fairlead.operate.services import Services
from fairlead.operate.subscription import watch
from fairlead.reason_text import short_text
from fairlead.wire.bus import Qos

REPEAT_S = 0.04
"""With nine of ten lost, and a tick of 50 ms to wait, the robot still holds within 500 ms."""
TIMEOUT_S = 2.0
NO_REASON = "operator"
"""The reason of whoever gives none."""
MOST_STOPS = 16
"""That a gate holds; the last then stands for all that find no place."""


async def request_stop(services: Services, reason: str) -> int:
    """Request a protective stop, repeated until a lease lists it.

    Args:
        reason: for the log; no text keeps the stop from being sent.

    Returns:
        The stop's id, which a reset must cite.

    Raises:
        NoAnswerError: no lease listed it in time; the robot may still move. Not where the gate
            holds as many stops as it can: then the id of the last of these is returned.
    """
    reason = short_text(str(reason))
    stop_id = secrets.randbits(63) + 1
    held: tuple[int, ...] = ()
    changes = Changes()

    def on_lease(lease: Lease) -> None:
        nonlocal held
        held = lease.stop_ids
        changes.announce()

    def is_held() -> bool:
        return stop_id in held or len(held) == MOST_STOPS

    bus, keys = services.bus, services.keys
    leases = watch(bus, keys.lease, Lease, on_lease)
    publisher = bus.publisher(keys.stop, StopLevel, Qos.HOT)
    message = StopLevel(stop_id=stop_id, by=short_text(services.by), reason=reason)
    due_s = time.monotonic()
    deadline_s = due_s + TIMEOUT_S
    try:
        while time.monotonic() <= deadline_s:
            publisher.put(message)
            due_s += REPEAT_S  # not from when the wait ended: that would add up
            pause_s = max(0.0, due_s - time.monotonic())
            if await changes.wait_for(is_held, pause_s):
                return stop_id if stop_id in held else held[-1]
    finally:
        leases.close()
    raise NoAnswerError(
        f"robot {services.deployment.id}: no lease lists the stop after {TIMEOUT_S:g} s: THE GATE "
        "IS NOT ANSWERING; the HAL holds on its own 75 ms after the last lease; see: fairlead ps"
    )
