"""``hal/status``: who the robot is and how it is paced, on change, at 2 Hz, on query."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from fairlead.hal.backend import BackendDescription
from fairlead.hal.identity import HalIdentity, HostSettings
from fairlead.messages import HalCamera, HalStatus, StatusQuery, decode
from fairlead.wire.bus import Bus, Qos

INTERVAL_NS = 500_000_000

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
            self._due_ns = now_ns + INTERVAL_NS
            self._publisher.put(self._status)

    def close(self) -> None:
        """Answer no more queries."""
        self._queryable.undeclare()

    def _answer(self, payload: bytes) -> HalStatus:
        decode(StatusQuery, payload)
        return self._status
