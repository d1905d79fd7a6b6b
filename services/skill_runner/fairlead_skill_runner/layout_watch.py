"""Is the state vector still coming? A goal in motion does not wait for one that stopped."""

from __future__ import annotations

import math

FAULTS_TO_FAIL = 4
"""In a row: in lockstep, where the world waits, and before a goal has seen a good layout."""
FAULTS_IN_MOTION = 2
"""In a row, of two ticks: realtime, where rows that were released before go on acting."""
SILENCE_S = 0.75
"""Realtime: a goal fails so long after its newest layout; rows may never start again by
themselves because an assembler came back."""


class LayoutWatch:
    """Counts faulty layouts in a row and, in realtime, ticks without any.

    In lockstep the world waits for a layout, and the goal ends by its stall timeout.

    Args:
        rate_hz: control periods a second.
    """

    def __init__(self, *, lockstep: bool, rate_hz: float) -> None:
        self._lockstep = lockstep
        self._silence_ticks = math.ceil(SILENCE_S * rate_hz)
        self._faults = self._fault_tick = self._good_tick = 0

    def good(self, tick: int) -> None:
        """A state vector of ``tick`` came."""
        self._faults = 0
        self._good_tick = max(self._good_tick, tick)

    def is_last_fault(self, tick: int) -> bool:
        """Count a faulty layout; in realtime one tick may be told twice, and counts once."""
        if self._lockstep or tick > self._fault_tick:
            self._faults, self._fault_tick = self._faults + 1, tick
        waits = self._lockstep or not self._good_tick
        return self._faults >= (FAULTS_TO_FAIL if waits else FAULTS_IN_MOTION)

    def silent_ticks(self, tick: int) -> int:
        """Ticks since the newest layout if these are too many at ``tick``, else 0."""
        if self._lockstep or not self._good_tick:
            return 0
        silent = tick - self._good_tick
        return silent if silent > self._silence_ticks else 0
