"""The stops a HAL holds, and when it may let go of one."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.messages import GateState, Lease, StopLevel

NO_ID = 0
STOP_WITHOUT_ID = "stop without an id"
MAX_STOPS = 16
"""Stops held by their own ids, as many as a lease lists; all others by one of the HAL's."""
TOO_MANY = "more stops than can be held"
MAX_RESET_IDS = 256
"""Ids remembered after their reset, the newest: late copies of them are ignored."""


@dataclass
class _HeldStop:
    message: StopLevel
    listed_epoch: int  # epoch of the newest lease that listed it, 0 if none did


class StopRegister:
    """Stops are held until the gate that listed them lists them no longer.

    The gate lists a stop for as long as it stands, so a later lease of the same epoch
    without it means that an operator reset it; a lost or late message can never end a stop.
    A gate that was started anew knows nothing of it and is told: there only an armed lease,
    of yet another epoch, ends it. Ids that were let go are remembered: late copies of them
    are ignored.

    Some causes need a stop of the HAL's own, under a fresh id (two gates, a stop message
    that cannot be listed, more stops than a lease lists). They count as held from the moment
    they are demanded until the host has raised that stop, and are demanded again only when it
    has been reset.
    """

    def __init__(self) -> None:
        self._held: dict[int, _HeldStop] = {}
        self._dropped: dict[int, None] = {}  # the oldest first
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
        self._held[stop.stop_id] = _HeldStop(stop, listed_epoch=0)
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
        if len(self._held) >= MAX_STOPS:
            self.demand(TOO_MANY, f"{MAX_STOPS} are held already")
            return TOO_MANY
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
        is_armed = lease.state == GateState.ARMED
        for stop_id, held in list(self._held.items()):
            # An armed gate has begun another epoch since it listed a stop.
            was_listed = held.listed_epoch and is_armed == (held.listed_epoch != lease.epoch)
            if was_listed and stop_id not in self._listed_now:
                self._drop(stop_id)

    def to_repeat(self) -> tuple[StopLevel, ...]:
        """Held stops that the newest lease does not list: repeat them every 50 ms."""
        return tuple(
            held.message for stop_id, held in self._held.items() if stop_id not in self._listed_now
        )

    def _drop(self, stop_id: int) -> None:
        del self._held[stop_id]
        self._dropped[stop_id] = None
        if len(self._dropped) > MAX_RESET_IDS:
            del self._dropped[next(iter(self._dropped))]
