"""When the next realtime tick is due. Pure: the caller's clock is an argument."""

from __future__ import annotations


class PeriodClock:
    """Ticks every ``period_ns``; a late tick moves all later ones (slips), never bursts.

    Attributes:
        overruns: ticks that began later than they were due because work took too long.
    """

    def __init__(self, period_ns: int, now_ns: int) -> None:
        self._period_ns = period_ns
        self._due_ns = now_ns
        self.overruns = 0

    def start_tick(self, now_ns: int) -> int:
        """Nanoseconds still to wait before the next tick may begin (0: begin now)."""
        self._due_ns += self._period_ns
        if now_ns > self._due_ns:
            self._due_ns = now_ns
            self.overruns += 1
        return self._due_ns - now_ns

    def restart(self, now_ns: int) -> None:
        """After a deliberate break (an episode reset) the next tick is a period from now."""
        self._due_ns = now_ns
