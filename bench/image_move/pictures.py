"""What is moved, and when it has arrived. Needs numpy alone: dora's environment runs it too."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

HZ = 30.0
WARM_UP = 15
"""Ticks that do not count."""
FIRST_S = 1.0
"""Until the first one, so that all are connected."""
PATIENCE_S = 20.0
"""How long after the last one a receiver waits for what is missing."""
_KINDS = 4

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Case:
    """Pictures of so many cameras in each tick."""

    name: str
    width: int
    height: int
    cameras: int

    @property
    def size(self) -> int:
        """Bytes of one."""
        return self.width * self.height * 3


CASES = (Case("2 x 224 x 224", 224, 224, 2), Case("640 x 480", 640, 480, 1))


def ticks(case: Case, count: int) -> Iterator[list[Pixels]]:
    """Each tick's pictures, when it is due, with its time and number at both ends of each."""
    rng = np.random.default_rng(0)
    shape = (_KINDS, case.cameras, case.height, case.width, 3)
    drawn = rng.integers(0, 256, shape, np.uint8)
    due_s = time.monotonic() + FIRST_S
    for tick in range(count):
        time.sleep(max(0.0, due_s - time.monotonic()))
        due_s += 1 / HZ
        pictures = list(drawn[tick % _KINDS])
        stamp = np.array([time.monotonic_ns(), tick], "<i8").view(np.uint8)
        for one in pictures:
            flat = one.reshape(-1)
            flat[: len(stamp)] = flat[-len(stamp) :] = stamp
        yield pictures


@dataclass
class Arrivals:
    """latencies_us: from a tick's time until the last of its pictures was an array."""

    case: Case
    count: int
    latencies_us: list[float] = field(default_factory=list)
    _seen: dict[int, int] = field(default_factory=dict)

    def add(self, picture: npt.NDArray[Any]) -> bool:
        """Take one that has arrived; True once the last tick's have.

        Raises:
            ValueError: it is not whole.
        """
        flat = picture.reshape(-1)
        (stamp, tick), last = flat[:16].view("<i8").tolist(), flat[-16:].view("<i8").tolist()
        now = time.monotonic_ns()
        if [stamp, tick] != last or flat.size != self.case.size:
            raise ValueError("expected a whole picture")
        self._seen[tick] = self._seen.get(tick, 0) + 1
        if self._seen[tick] < self.case.cameras:
            return False
        if tick >= WARM_UP:
            self.latencies_us.append((now - stamp) / 1e3)
        return bool(tick == self.count - 1)
