"""How long to wait before a service that died is started again."""

from __future__ import annotations

from dataclasses import dataclass

FIRST_DELAY_S = 0.5
LONGEST_DELAY_S = 10.0
FORGIVEN_AFTER_S = 30.0  # a service that ran this long starts over at the first delay


@dataclass
class Backoff:
    """Doubling delays, forgotten after a long enough life."""

    _next_s: float = FIRST_DELAY_S

    def delay_s(self, lived_s: float) -> float:
        """The delay [s] for a process that died after ``lived_s`` seconds."""
        if lived_s >= FORGIVEN_AFTER_S:
            self._next_s = FIRST_DELAY_S
        delay = self._next_s
        self._next_s = min(2.0 * delay, LONGEST_DELAY_S)
        return delay
