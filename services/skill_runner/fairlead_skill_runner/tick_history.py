"""What came of each tick, as far back as a policy looks; and what is wrong with a camera's frames.

A frame counts if its exposure is new and it shows something. What tells a repeat is the exposure's
tick, never the pixels: a still scene looks the same in every picture.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import Generic, Protocol, TypeVar

import numpy as np

from fairlead.messages import Image


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


_LOOKED_AT = 64
"""Rows and columns of a picture, about, in which contrast is looked for."""
_SPACINGS = 8


class FrameHistory(TickHistory[Image]):
    """Frames by tick.

    Args:
        ticks_back: the oldest that is wanted, in ticks before the newest.
        contrast_min: see `ImageSpec`.
    """

    def __init__(self, ticks_back: int, contrast_min: float) -> None:
        super().__init__(ticks_back)
        self._contrast_min = contrast_min
        self._repeated = self._blank = 0  # frames since the newest that counts
        self._last = deque[int](maxlen=_SPACINGS + 1)  # ticks of frames that counted

    def add(self, image: Image) -> None:
        """Keep a frame that counts."""
        if image.tick in self._kept:
            self._repeated += 1
            return
        if self._contrast_min and contrast(image) < self._contrast_min:
            self._blank += 1
            return
        if self.newest is None or image.tick > self.newest.tick:
            self._repeated = self._blank = 0
        self.keep(image)
        self._last.append(image.tick)

    def trouble(self) -> str:
        """What has come since the newest frame that counts; "" if nothing has."""
        if self._blank:
            return f"{self._blank} pictures of one colour came since (contrast_min)"
        return f"its last exposure came {self._repeated} times more" if self._repeated else ""

    def spacing(self) -> str:
        """How far the last frames that count are apart; there were at least two."""
        apart = [after - before for before, after in pairwise(sorted(self._last))]
        least, most = min(apart), max(apart)
        return f"{least} ticks apart" if least == most else f"{least} to {most} ticks apart"


def contrast(image: Image) -> float:
    """Standard deviation of the channel that varies most [levels of 255].

    Of depths, their largest is 255, and what was not measured (0, infinite, NaN) does not count;
    of what is not as long as it should be, infinite: that is said where the picture is taken.
    """
    numbers = image.width * image.height
    if image.encoding_name == "depth32f" and len(image.data) == 4 * numbers:
        depths = np.frombuffer(image.data, "<f4").astype(np.float64)
        depths = depths[np.isfinite(depths) & (depths > 0)]
        return float(255 * (depths / depths.max()).std()) if len(depths) else 0.0
    if image.encoding_name != "rgb8" or len(image.data) != 3 * numbers:
        return float("inf")
    pixels = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    step = max(1, min(image.height, image.width) // _LOOKED_AT)
    return float(pixels[::step, ::step].std(axis=(0, 1)).max(initial=0.0))
