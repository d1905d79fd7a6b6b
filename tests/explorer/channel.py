"""A network in virtual time that loses, delays, duplicates and reorders messages."""

from __future__ import annotations

import heapq
import random
from collections.abc import Callable
from dataclasses import dataclass

MS = 1_000_000


@dataclass(frozen=True)
class Weather:
    """What the channel does to each message; delays are drawn uniformly up to ``delay_ms``."""

    loss: float = 0.0
    duplicate: float = 0.0
    delay_ms: float = 0.0

    @property
    def is_fair(self) -> bool:
        return not (self.loss or self.duplicate or self.delay_ms)


FAIR = Weather()


class Schedule:
    """Events in virtual time, in order of time and, at the same time, of insertion."""

    def __init__(self) -> None:
        self.now_ns = 0
        self._events: list[tuple[int, int, Callable[[], None]]] = []
        self._count = 0

    def at(self, time_ns: int, action: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._events, (max(time_ns, self.now_ns), self._count, action))

    def run(self, until: Callable[[], bool], limit_ns: int) -> bool:
        """Run until the condition holds; False if virtual time reached ``limit_ns`` first."""
        while not until():
            if not self._events or self._events[0][0] > limit_ns:
                return False
            self.now_ns, _, action = heapq.heappop(self._events)
            action()
        return True


class Channel:
    """Carries each message in 0.2 ms in fair weather; else as the weather has it."""

    def __init__(self, schedule: Schedule, rng: random.Random) -> None:
        self._schedule = schedule
        self._rng = rng
        self.weather = FAIR
        self.lost = 0

    def send(self, deliver: Callable[[], None]) -> None:
        weather = self.weather
        copies = 2 if self._rng.random() < weather.duplicate else 1
        for _ in range(copies):
            if self._rng.random() < weather.loss:
                self.lost += 1
                continue
            delay_ns = round(self._rng.uniform(0.0, weather.delay_ms) * MS) + MS // 5
            self._schedule.at(self._schedule.now_ns + delay_ns, deliver)
