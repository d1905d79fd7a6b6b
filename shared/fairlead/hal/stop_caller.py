"""Raises the HAL's own stops and repeats every held one until the gate lists it."""

from __future__ import annotations

import logging
import secrets
from threading import Condition

from fairlead.hal.core import HalCore
from fairlead.hal.identity import HostSettings
from fairlead.messages import StopLevel
from fairlead.wire.bus import Bus, Qos

_LOG = logging.getLogger("hal.stop")

REPEAT_NS = 50_000_000
"""A stop is repeated this often until a lease lists it."""


class StopCaller:
    """Puts stops on ``safety/stop``; a lost one is repeated, so it cannot be missed."""

    def __init__(self, bus: Bus, settings: HostSettings, core: HalCore, changed: Condition) -> None:
        self._publisher = bus.publisher(settings.keys.stop, StopLevel, Qos.HOT)
        self._service = settings.service
        self._core = core
        self._changed = changed
        self._due_ns = 0

    def raise_stop(self, reason: str) -> None:
        """Hold a new stop of this HAL and tell everyone."""
        stop = self._new_stop(reason)
        with self._changed:
            self._core.on_stop(stop)
        self._publisher.put(stop)

    def raise_demanded(self) -> None:
        """Raise the stops that the core asks for."""
        with self._changed:
            demanded = self._core.demanded_stops
        for cause, detail in demanded:
            stop = self._new_stop(f"{cause}: {detail}")
            with self._changed:
                self._core.on_stop_raised(cause, stop)
            self._publisher.put(stop)

    def _new_stop(self, reason: str) -> StopLevel:
        stop = StopLevel(stop_id=secrets.randbits(63) + 1, by=self._service, reason=reason)
        _LOG.error("stop %x raised: %s", stop.stop_id, reason)
        return stop

    def repeat_due(self, now_ns: int) -> None:
        """Repeat, every 50 ms, the held stops that the newest lease does not list."""
        if now_ns < self._due_ns:
            return
        self._due_ns += REPEAT_NS * (1 + (now_ns - self._due_ns) // REPEAT_NS)  # late or not
        with self._changed:
            stops = self._core.stops_to_repeat()
        for stop in stops:
            self._publisher.put(stop)
