"""Which of many days are kept: all that is shown anywhere, in as few bytes as it takes."""

from __future__ import annotations

import random
from collections.abc import Sequence

from bench.days.day import Day


def choose(days: Sequence[Day], always: Sequence[Day], most_bytes: int) -> list[Day]:
    """``always``, then what shows most that is new for its bytes, then others by lot.

    Nothing is taken that does not fit into ``most_bytes``; the same days give the same choice.
    """
    kept: list[Day] = []
    seen: set[str] = set()
    left = sorted(days, key=lambda day: day.name)
    used = 0

    def take(day: Day) -> None:
        nonlocal used
        kept.append(day)
        seen.update(day.shows)
        used += day.size

    for day in always:
        take(day)
    while True:
        left = [day for day in left if day not in kept and used + day.size <= most_bytes]
        worth = {index: len(day.shows - seen) / day.size for index, day in enumerate(left)}
        if not worth or max(worth.values()) == 0.0:
            break
        take(left[max(worth, key=lambda index: worth[index])])
    random.Random(len(left)).shuffle(left)
    for day in left:
        if used + day.size <= most_bytes:
            take(day)
    return kept
