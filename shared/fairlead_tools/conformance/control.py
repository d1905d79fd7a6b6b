"""A thread that only sleeps: how late this machine wakes whoever is due."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

import numpy as np

JITTER_PERCENTILE = 90.0
SLEEP_S = 0.01


@dataclass(frozen=True)
class Lateness:
    """On the mean, at the percentile of the jitter, at most."""

    mean_s: float
    percentile_s: float
    most_s: float


class Control:
    """Sleeps for 10 ms again and again, and notes when it woke and how late that was."""

    def __init__(self) -> None:
        self._woke: list[tuple[int, float]] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        before_ns = time.monotonic_ns()
        while not self._ended.wait(SLEEP_S):
            now_ns = time.monotonic_ns()
            self._woke.append((now_ns, (now_ns - before_ns) * 1e-9 - SLEEP_S))
            before_ns = now_ns

    def since(self, began_ns: int) -> Lateness:
        """How late it woke from then on (CLOCK_MONOTONIC), and is late now."""
        woke = list(self._woke)
        last_ns = woke[-1][0] if woke else began_ns
        now_late = max(0.0, (time.monotonic_ns() - max(last_ns, began_ns)) * 1e-9 - SLEEP_S)
        late = np.array([one for at_ns, one in woke if at_ns >= began_ns] + [now_late])
        percentile = float(np.percentile(late, JITTER_PERCENTILE))
        return Lateness(float(late.mean()), percentile, float(late.max()))

    def close(self) -> None:
        """Sleep no more."""
        self._ended.set()
        self._thread.join()
