"""What a HAL says of itself: ``hal/status``, and its stops, each until the gate lists it."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Sequence
from typing import Any, Literal

import msgspec

from fairlead.hal.backend import BackendDescription
from fairlead.hal.identity import HalIdentity, HostSettings
from fairlead.hal.inbox import SharedCore
from fairlead.messages import HalCamera, HalStatus, StatusQuery, StopLevel, decode
from fairlead.reason_text import short_text
from fairlead.wire.bus import Bus, Qos

STATUS_INTERVAL_NS = 500_000_000

HalState = Literal["ready", "resetting", "holding", "fault"]


class StatusPublisher:
    """Publishes the newest status and answers queries with it.

    The tick thread replaces the status as a whole; queries are answered with the last one, on the
    transport's thread.
    """

    def __init__(
        self,
        bus: Bus,
        settings: HostSettings,
        identity: HalIdentity,
        found: BackendDescription,
    ) -> None:
        key = settings.keys.hal_status
        self._publisher = bus.publisher(key, HalStatus, Qos.STATUS)
        self._due_ns = 0
        self._status = HalStatus(
            session=settings.session,
            robot=identity.robot,
            robot_hash=identity.robot_hash,
            pacing=settings.pacing,
            period_ns=identity.period_ns,
            tick=0,
            episode_tick=0,
            state="resetting",
            detail="starting",
            joints=identity.joints,
            passive_joints=identity.passive_joints,
            parts=found.parts,
            simulator_order=found.simulator_order,
            cameras=found.cameras,
            has_task=found.has_task,
            overruns=0,
        )
        self._queryable = bus.serve(key, settings.service, self._answer)

    def post(
        self,
        now_ns: int,
        *,
        tick: int,
        episode_tick: int,
        state: HalState,
        detail: str,
        overruns: int,
        cameras: tuple[HalCamera, ...],
    ) -> None:
        """Take the current facts; publish if one of them (not only the tick) changed."""
        fields: dict[str, Any] = {
            "episode_tick": episode_tick,
            "state": state,
            "detail": detail,
            "overruns": overruns,
            "cameras": cameras,
        }
        before = self._status
        self._status = msgspec.structs.replace(before, tick=tick, **fields)
        changed = any(getattr(before, name) != value for name, value in fields.items())
        if changed or now_ns >= self._due_ns:
            self._due_ns = now_ns + STATUS_INTERVAL_NS
            self._publisher.put(self._status)

    def close(self) -> None:
        """Answer no more queries."""
        self._queryable.undeclare()

    def _answer(self, payload: bytes) -> HalStatus:
        decode(StatusQuery, payload)
        return self._status


_LOG = logging.getLogger("hal.stop")

STOP_REPEAT_NS = 50_000_000
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
        late = (now_ns - self._due_ns) // STOP_REPEAT_NS
        self._due_ns += STOP_REPEAT_NS * (1 + late)
        for stop in self._core.read(lambda core: core.stops_to_repeat()):
            self._publisher.put(stop)
