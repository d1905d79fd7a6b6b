"""Raises the HAL's own stops and repeats every held one until the gate lists it."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Sequence

from fairlead.hal.identity import HostSettings
from fairlead.hal.shared_core import SharedCore
from fairlead.messages import StopLevel
from fairlead.reason_text import short_text
from fairlead.wire.bus import Bus, Qos

_LOG = logging.getLogger("hal.stop")

REPEAT_NS = 50_000_000
"""A stop is repeated this often until a lease lists it."""
MAX_NAMED_STOPS = 4


def names_of(stops: Sequence[StopLevel]) -> str:
    """The first stops by id and reason, for a status."""
    named = ", ".join(f"{s.stop_id:016x} ({short_text(s.reason)})" for s in stops[:MAX_NAMED_STOPS])
    more = len(stops) - MAX_NAMED_STOPS
    return f"stop {named}" + (f" and {more} more" if more > 0 else "")


class StopPublisher:
    """Puts stops on ``safety/stop``; a lost one is repeated, so it cannot be missed."""

    def __init__(self, bus: Bus, settings: HostSettings, core: SharedCore) -> None:
        self._publisher = bus.publisher(settings.keys.stop, StopLevel, Qos.HOT)
        self._service = settings.service
        self._core = core
        self._due_ns = 0

    def raise_stop(self, reason: str) -> None:
        """Hold a new stop of this HAL and tell everyone."""
        stop = self._new_stop(reason)
        self._core.change(lambda core: core.on_stop(stop))
        self._publisher.put(stop)

    def raise_demanded(self) -> None:
        """Raise the stops that the core asks for."""
        for cause, detail in self._core.read(lambda core: core.demanded_stops):
            self._raise_for(cause, self._new_stop(f"{cause}: {detail}"))

    def _raise_for(self, cause: str, stop: StopLevel) -> None:
        self._core.change(lambda core: core.on_stop_raised(cause, stop))
        self._publisher.put(stop)

    def _new_stop(self, reason: str) -> StopLevel:
        reason = short_text(reason)  # of a driver, an operator: else the gate could not read it
        stop = StopLevel(stop_id=secrets.randbits(63) + 1, by=self._service, reason=reason)
        _LOG.error("stop %x raised: %s", stop.stop_id, reason)
        return stop

    def repeat_due(self, now_ns: int) -> None:
        """Repeat, every 50 ms, the held stops that the newest lease does not list."""
        if now_ns < self._due_ns:
            return
        self._due_ns += REPEAT_NS * (1 + (now_ns - self._due_ns) // REPEAT_NS)  # late or not
        for stop in self._core.read(lambda core: core.stops_to_repeat()):
            self._publisher.put(stop)
