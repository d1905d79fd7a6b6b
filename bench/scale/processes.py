"""Processes of a measurement: started with a log each, and what they spend in a window of time."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bench.equipment.live_robot import wait_for
from bench.tick_watch import Spent, spent
from fairlead.errors import ServiceError
from fairlead_tools.supervisor.child import die_with_parent

END_S, MOVES_S, SETTLE_S = 20.0, 40.0, 2.0
LAST_LINES = 10


class Process:
    """One that runs, and the file that has what it prints."""

    def __init__(
        self, words: Sequence[str], log: Path, environment: Mapping[str, str], folder: Path
    ) -> None:
        log.parent.mkdir(parents=True, exist_ok=True)
        self.log = log
        with log.open("wb") as out:
            self._process = subprocess.Popen(
                die_with_parent(words),
                stdout=out,
                stderr=subprocess.STDOUT,
                env=dict(environment),
                cwd=folder,
            )
        self.pid = self._process.pid

    def has_said(self, word: str) -> bool:
        """Whether it has printed it."""
        return word in self.log.read_text(encoding="utf-8", errors="replace")

    def wait_for(self, condition: Callable[[], bool], what: str, timeout_s: float) -> None:
        """Until a condition holds that it brings about.

        Raises:
            ServiceError: it ended, with its last lines, or took too long.
        """

        def holds() -> bool:
            status = self._process.poll()
            if status is not None:
                text = self.log.read_text(encoding="utf-8", errors="replace")
                last = "\n".join(text.splitlines()[-LAST_LINES:])
                raise ServiceError(f"{self.log.stem} ended with {status}:\n{last}")
            return condition()

        try:
            wait_for(holds, what, timeout_s)
        except AssertionError:
            raise ServiceError(f"{self.log.stem}: {what}: not within {timeout_s:g} s") from None

    def end(self) -> None:
        """Ask it to."""
        self._process.terminate()

    def gone(self) -> None:
        """Until it has ended, killed if it does not."""
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(END_S)


def ended(processes: Sequence[Process]) -> None:
    """End all of them, together."""
    for one in processes:
        one.end()
    for one in processes:
        one.gone()


def settle(way: str, moving: Callable[[], int], count: int) -> None:
    """Until all robots move; on a machine that is full, say how many do and go on."""
    try:
        wait_for(lambda: moving() == count, "all robots move", MOVES_S)
    except AssertionError:
        print(f"bench.scale: {way}: {moving()} of {count} robots move", file=sys.stderr)
    time.sleep(SETTLE_S)  # what begins costs more than what goes on


@dataclass(frozen=True)
class Spending:
    """Of named groups of processes, and of the whole machine, in a window.

    groups: processor time [ms] and memory.
    busy: share of all processors' time in which they did something, for anybody.
    """

    began_ns: int
    ended_ns: int
    groups: Mapping[str, Spent]
    busy: float

    @property
    def seconds(self) -> float:
        """How long it was."""
        return (self.ended_ns - self.began_ns) / 1e9


def spending(groups: Mapping[str, Iterable[int]], seconds: float) -> Spending:
    """Watch processes for so long.

    Raises:
        ServiceError: one of them has ended.
    """
    lists = {name: list(pids) for name, pids in groups.items()}
    machine, began_ns = _machine(), time.monotonic_ns()
    try:
        before = {name: [spent(pid, alone=True) for pid in pids] for name, pids in lists.items()}
        time.sleep(seconds)  # what is measured is time
        after = {name: [spent(pid, alone=True) for pid in pids] for name, pids in lists.items()}
    except (KeyError, OSError) as error:  # what has ended spends nothing more
        raise ServiceError(f"a process ended while it was measured ({error})") from None
    ended_ns, later = time.monotonic_ns(), _machine()
    total, idle = (now - then for now, then in zip(later, machine, strict=True))
    return Spending(
        began_ns,
        ended_ns,
        {
            name: _sum(now.since(then) for now, then in zip(after[name], before[name], strict=True))
            for name in lists
        },
        1 - idle / total,
    )


def _sum(each: Iterable[Spent]) -> Spent:
    found = list(each)
    return Spent(
        sum(one.running_ms for one in found),
        sum(one.waiting_ms for one in found),
        sum(one.memory_mb for one in found),
    )


def _machine() -> tuple[int, int]:
    """All time of all processors, and the idle part of it."""
    first = Path("/proc/stat").read_text().splitlines()[0].split()[1:9]
    numbers = [int(one) for one in first]
    return sum(numbers), numbers[3] + numbers[4]
