"""What came of each tick, as far back as a policy looks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, Protocol, TypeVar


class _Timed(Protocol):
    @property
    def tick(self) -> int: ...


Timed = TypeVar("Timed", bound=_Timed)


class TickHistory(Generic[Timed]):
    """Messages of one kind by tick.

    Args:
        ticks_back: the oldest that is wanted, in ticks before the newest.
    """

    def __init__(self, ticks_back: int) -> None:
        self._ticks_back = ticks_back
        self._kept: dict[int, Timed] = {}
        self._first_tick = 0
        self.newest: Timed | None = None

    def keep(self, one: Timed) -> None:
        """One that comes late may still be wanted."""
        if self.newest is None:
            self._first_tick = one.tick
        if self.newest is None or one.tick > self.newest.tick:
            self.newest = one
        self._kept[one.tick] = one
        oldest = self.newest.tick - self._ticks_back
        for tick in [tick for tick in self._kept if tick < oldest]:
            del self._kept[tick]

    def missing_tick(self, deltas: Sequence[int], episode_tick: int) -> int | None:
        """The tick of one that was due and is not here; None if all are.

        Args:
            deltas: in ticks, the last of them 0.
            episode_tick: those before it are of another episode.
        """
        ticks = self._wanted(deltas, episode_tick)
        return next((tick for tick in ticks if tick not in self._kept), None)

    def at(self, deltas: Sequence[int], episode_tick: int) -> list[Timed]:
        """Oldest first; call it when none is missing."""
        return [self._kept[tick] for tick in self._wanted(deltas, episode_tick)]

    def _wanted(self, deltas: Sequence[int], episode_tick: int) -> list[int]:
        """Before the first of a goal or an episode there is that one again."""
        assert self.newest is not None
        begun = max(self._first_tick, episode_tick)
        first = min((tick for tick in self._kept if tick >= begun), default=self.newest.tick)
        wanted = (self.newest.tick + delta for delta in deltas)
        return [tick if tick >= begun else first for tick in wanted]
