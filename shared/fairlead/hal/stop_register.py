"""The stops a HAL holds, and when it may let go of one."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.messages import GateState, Lease, StopLevel

NO_ID = 0
STOP_WITHOUT_ID = "stop without an id"


@dataclass
class _HeldStop:
    message: StopLevel
    listed_epoch: int  # epoch of the newest lease that listed it, 0 if none did


class StopRegister:
    """Stops are held until a lease listed them and an armed lease of another epoch does not.

    The gate lists a stop for as long as it stands, and only an operator's reset followed by
    a new arm opens another epoch, so a lost or late message can never end a stop. Ids that
    were let go are remembered: late copies of them are ignored.

    Some causes need a stop of the HAL's own, under a fresh id (two gates, a stop message
    that cannot be listed). They count as held from the moment they are demanded until the
    host has raised that stop, and are demanded again only when it has been reset.
    """

    def __init__(self) -> None:
        self._held: dict[int, _HeldStop] = {}
        self._dropped: set[int] = set()
        self._listed_now: frozenset[int] = frozenset()
        self._demanded: dict[str, str] = {}  # details by cause
        self._raised: dict[str, int] = {}  # stop ids by cause

    @property
    def held(self) -> tuple[StopLevel, ...]:
        """The stops held now, as they were raised, in the order they came."""
        return tuple(held.message for held in self._held.values())

    @property
    def any_held(self) -> bool:
        """Whether a stop holds the robot, or one of this HAL's own is still to be raised."""
        return bool(self._held or self._demanded)

    @property
    def demanded(self) -> tuple[tuple[str, str], ...]:
        """Stops that this HAL still has to raise: cause and details."""
        return tuple(self._demanded.items())

    def demand(self, cause: str, detail: str) -> None:
        """Ask for a stop of this HAL's own, once while the one for this cause is held."""
        if self._raised.get(cause) not in self._held:
            self._demanded.setdefault(cause, detail)

    def raised(self, cause: str, stop: StopLevel) -> None:
        """Hold the stop that was demanded for ``cause``."""
        self.hold(stop)
        self._raised[cause] = stop.stop_id
        self._demanded.pop(cause, None)

    def hold(self, stop: StopLevel) -> str:
        """Hold a stop. Returns "" if it is new, else why it is not held under its id."""
        if stop.stop_id == NO_ID:  # no lease could list it, no reset could cite it
            self.demand(STOP_WITHOUT_ID, f"by {stop.by}: {stop.reason}")
            return STOP_WITHOUT_ID
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
