"""The control: a process that only sleeps, and how late the machine woke it.

A bound that this process misses too says nothing about the robot.
"""

from __future__ import annotations

import struct
import subprocess
import sys
import threading
import time

PERIOD_S = 0.005
_ENTRY = struct.Struct("<qq")


def _sleep_for_ever() -> None:
    period_ns, out = int(PERIOD_S * 1e9), sys.stdout.buffer
    while True:
        due_ns = time.monotonic_ns() + period_ns
        time.sleep(PERIOD_S)  # what is measured
        now_ns = time.monotonic_ns()
        out.write(_ENTRY.pack(now_ns, now_ns - due_ns))
        out.flush()


class TimerProcess:
    """Runs beside the campaign; asked afterwards about a stretch of time."""

    def __init__(self) -> None:
        words = [sys.executable, "-m", "bench.faults.timer_process"]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE)
        self._entries: list[tuple[int, int]] = []
        self._grown = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> TimerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join()

    def late_ms(self, began_ns: int, ended_ns: int) -> list[float]:
        """How late each wake-up was whose sleep touched that stretch [ms]; at least one."""
        margin_ns = 10_000_000
        with self._grown:
            is_over = self._grown.wait_for(
                lambda: self._entries and self._entries[-1][0] >= ended_ns, 10.0
            )
        assert is_over, "the timer process does not wake up"
        return [
            late_ns / 1e6
            for now_ns, late_ns in self._entries
            if now_ns >= began_ns and now_ns - late_ns - margin_ns <= ended_ns
        ] or [0.0]

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            while len(entry := stream.read(_ENTRY.size)) == _ENTRY.size:
                with self._grown:
                    self._entries.append(_ENTRY.unpack(entry))
                    self._grown.notify_all()


if __name__ == "__main__":
    _sleep_for_ever()
