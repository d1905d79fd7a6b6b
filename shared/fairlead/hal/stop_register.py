"""The stops a HAL holds, and when it may let go of one."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.messages import GateState, Lease, StopLevel


@dataclass
class _HeldStop:
    message: StopLevel
    listed_epoch: int  # epoch of the newest lease that listed it, 0 if none did


class StopRegister:
    """Stops are held until a lease listed them and an armed lease of another epoch does not.

    The gate lists a stop for as long as it stands, and only an operator's reset followed by
    a new arm opens another epoch, so a lost or late message can never end a stop. Ids that
    were let go are remembered: late copies of them are ignored.
    """

    def __init__(self) -> None:
        self._held: dict[int, _HeldStop] = {}
        self._dropped: set[int] = set()
        self._listed_now: frozenset[int] = frozenset()

    @property
    def ids(self) -> tuple[int, ...]:
        return tuple(self._held)

    @property
    def any_held(self) -> bool:
        return bool(self._held)

    def hold(self, stop: StopLevel) -> str:
        """Hold a stop. Returns "" if it is new, else why nothing changed."""
        if stop.stop_id in self._dropped:
            return "stop already reset"
        if stop.stop_id in self._held:
            return "stop already held"
        self._held[stop.stop_id] = _HeldStop(stop, listed_epoch=0)
        return ""

    def on_lease(self, lease: Lease) -> None:
        """Take what a newly followed lease says about stops."""
        self._listed_now = frozenset(lease.stop_ids)
        for stop_id in lease.stop_ids:
            if stop_id in self._dropped:
                continue
            if stop_id not in self._held:
                stop = StopLevel(stop_id=stop_id, by="safety", reason="listed in a lease")
                self._held[stop_id] = _HeldStop(stop, listed_epoch=0)
            self._held[stop_id].listed_epoch = lease.epoch
        if lease.state == GateState.ARMED:
            self._drop_those_reset(lease.epoch)

    def to_repeat(self) -> tuple[StopLevel, ...]:
        """Held stops that the newest lease does not list: repeat them every 50 ms."""
        return tuple(
            held.message for stop_id, held in self._held.items() if stop_id not in self._listed_now
        )

    def _drop_those_reset(self, armed_epoch: int) -> None:
        for stop_id, held in list(self._held.items()):
            was_listed_before = held.listed_epoch not in (0, armed_epoch)
            if was_listed_before and stop_id not in self._listed_now:
                del self._held[stop_id]
                self._dropped.add(stop_id)
