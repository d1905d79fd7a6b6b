"""The heartbeats that keep a claim alive."""

from __future__ import annotations

import asyncio

from fairlead.messages import Heartbeat
from fairlead.wire.bus import Publisher

HEARTBEAT_S = 0.05


async def beat(publisher: Publisher, claim_id: int) -> None:
    """Beat for a claim, at once and every 50 ms, until cancelled: a loop that hangs loses it."""
    while True:
        publisher.put(Heartbeat(claim_id=claim_id))
        await asyncio.sleep(HEARTBEAT_S)
