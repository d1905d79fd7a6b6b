"""Time that this computer slept through: no other clock of the HAL or the gate counts it."""

from __future__ import annotations

import time

SUSPENDED_NS = 10_000_000
"""More than clocks that are read one after the other differ by."""


def suspended_ns() -> int:
    """How long this computer has been suspended, in all: the monotonic clock stands still then."""
    while True:
        before_ns = time.monotonic_ns()
        counted_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        if time.monotonic_ns() - before_ns < SUSPENDED_NS:  # else this process had to wait
            return counted_ns - before_ns
