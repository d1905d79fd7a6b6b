"""How much of the machine others used: what a robot misses meanwhile says nothing of a fault."""

from __future__ import annotations

import os
import time
from pathlib import Path

_PER_S = os.sysconf("SC_CLK_TCK")
_BUSY = (0, 1, 2, 5, 6, 7)  # of /proc/stat: user, nice, system, irq, softirq, steal
_OWN = slice(11, 15)  # of /proc/PID/stat behind the name: its times, and its ended children's


class OtherLoad:
    """CPU time of all but this process and those below it, from when this is made."""

    def __init__(self) -> None:
        self._began_s, self._others_s = time.monotonic(), _others_s()

    def cores(self) -> float:
        """How many cores they kept busy, on average."""
        return (_others_s() - self._others_s) / (time.monotonic() - self._began_s)


def _others_s() -> float:
    machine = Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:]
    busy = sum(int(machine[i]) for i in _BUSY)
    return busy / _PER_S - own_s()


def own_s() -> float:
    """CPU time of this process and all below it [s]."""
    children: dict[int, list[int]] = {}
    ticks: dict[int, int] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        children.setdefault(int(fields[1]), []).append(int(entry.name))
        ticks[int(entry.name)] = sum(map(int, fields[_OWN]))
    found, total = [os.getpid()], 0
    while found:
        pid = found.pop()
        total += ticks.get(pid, 0)
        found += children.get(pid, [])
    return total / _PER_S
