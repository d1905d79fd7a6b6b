"""A camera's frames, as far back as the pictures of a goal go."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.messages import Image


class FrameHistory:
    """Frames by tick.

    Args:
        ticks_back: the oldest that is wanted, in ticks before the newest.
    """

    def __init__(self, ticks_back: int) -> None:
        self._ticks_back = ticks_back
        self._frames: dict[int, Image] = {}
        self._first_tick = 0
        self.newest: Image | None = None

    def add(self, image: Image) -> None:
        """Keep a frame; one that comes late may still be wanted."""
        if self.newest is None:
            self._first_tick = image.tick
        if self.newest is None or image.tick > self.newest.tick:
            self.newest = image
        self._frames[image.tick] = image
        oldest = self.newest.tick - self._ticks_back
        for tick in [tick for tick in self._frames if tick < oldest]:
            del self._frames[tick]

    def missing_tick(self, deltas: Sequence[int], episode_tick: int) -> int | None:
        """The tick of a frame that was due and is not here; None if all are.

        Args:
            deltas: in ticks, the last of them 0.
            episode_tick: frames before it are of another episode.
        """
        ticks = self._wanted(deltas, episode_tick)
        return next((tick for tick in ticks if tick not in self._frames), None)

    def at(self, deltas: Sequence[int], episode_tick: int) -> list[Image]:
        """The frames, oldest first; call it when none is missing."""
        return [self._frames[tick] for tick in self._wanted(deltas, episode_tick)]

    def _wanted(self, deltas: Sequence[int], episode_tick: int) -> list[int]:
        """Before the first frame of a goal or an episode there is that one again."""
        assert self.newest is not None
        begun = max(self._first_tick, episode_tick)
        first = min((tick for tick in self._frames if tick >= begun), default=self.newest.tick)
        wanted = (self.newest.tick + delta for delta in deltas)
        return [tick if tick >= begun else first for tick in wanted]
