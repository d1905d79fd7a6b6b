"""How even the ticks of the HAL host are on a busy machine, beside a plain asyncio loop.

    .venv/bin/python -m bench.jitter [--seconds 30] [--hogs 2] [--json] [--write]

A HAL without physics and a loop that sleeps until its next tick, each in a process of its own, tick
at the same rate beside processes that do nothing but compute: first both as ordinary processes,
then the HAL with a real-time priority, as a robot's deployment file gives it. A tick's error is how
far its time from the tick before is from the period. Times are CLOCK_MONOTONIC, taken by each
itself; the HAL's are those of its own log.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import MotionLog
from bench.page import Write, write_table
from fairlead.deploy.scheduling import realtime_words
from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
PRIORITIES = {"ordinary": 0, "real-time": 20}
AIM = 0.25
WARM_UP_S = 2.0
_HOG = "while True: pass"
_LOOP = """
import asyncio, sys, time
async def main(period_s):
    due_s = time.monotonic()
    while True:
        due_s = max(due_s + period_s, time.monotonic())
        await asyncio.sleep(due_s - time.monotonic())
        print(time.monotonic_ns(), flush=True)
asyncio.run(main(float(sys.argv[1])))
"""


@dataclass(frozen=True)
class Errors:
    """Of ticks: how many, and median, 99.9 % and largest error [ms]."""

    ticks: int
    p50_ms: float
    p999_ms: float
    most_ms: float

    @classmethod
    def of(cls, stamps_ns: Sequence[int], period_ns: int) -> Errors:
        """From the times at which ticks came."""
        errors = sorted(abs(after - one - period_ns) / 1e6 for one, after in pairwise(stamps_ns))
        at = [errors[min(len(errors) - 1, math.ceil(q * len(errors)) - 1)] for q in (0.5, 0.999)]
        return cls(len(errors), at[0], at[1], errors[-1])


@dataclass(frozen=True)
class Measured:
    """One priority of the HAL, and the loop beside it."""

    priority: str
    hal: Errors
    loop: Errors

    @property
    def ratio(self) -> float:
        """Of the 99.9 % errors."""
        return self.hal.p999_ms / self.loop.p999_ms


@contextmanager
def running(words: Sequence[str], log: Path) -> Iterator[None]:
    """A process that writes into ``log`` and is ended at last."""
    with log.open("wb") as out:
        process = subprocess.Popen(words, stdout=out, stderr=subprocess.STDOUT)
        try:
            yield
        finally:
            process.terminate()
            process.wait(30.0)


def measure(priority: str, seconds: float, hogs: int, folder: Path) -> Measured:
    """Both at once, beside the hogs."""
    scratch = make_scratch(
        SOURCE, folder / "robot", ScratchOptions(pacing="realtime", hal=LIGHT_HAL)
    )
    period_ns = load_robot(scratch.deployment.robot).tick_period_ns
    name, state = scratch.deployment.hal, folder / "hal"
    state.mkdir()
    hal = [
        *realtime_words(name, PRIORITIES[priority]), sys.executable, "-m", "fairlead.hal.serve",
        "--deployment", str(scratch.file), "--service", name, "--state-dir", str(state),
    ]  # fmt: skip
    loop = [sys.executable, "-c", _LOOP, str(period_ns / 1e9)]
    ticks, motion = folder / "loop.log", MotionLog(state)
    with ExitStack() as stack:
        stack.enter_context(running(hal, folder / "hal.log"))
        stack.enter_context(running(loop, ticks))
        wait_for(lambda: (state / "motion.jsonl").exists() and bool(motion.read()), "ticks", 60.0)
        for number in range(hogs):
            stack.enter_context(running([sys.executable, "-c", _HOG], folder / f"hog{number}"))
        time.sleep(WARM_UP_S)  # what is measured is time
        began_ns = time.monotonic_ns()
        time.sleep(seconds)
        ended_ns = time.monotonic_ns()
        told = [line.stamp_ns for line in motion.since(began_ns)]
    slept = [int(line) for line in ticks.read_text().splitlines() if line.isdecimal()]
    kept = [[at for at in one if began_ns <= at <= ended_ns] for one in (told, slept)]
    return Measured(priority, *(Errors.of(one, period_ns) for one in kept))


def table(found: Sequence[Measured], hogs: int) -> str:
    """Markdown."""
    rows = [
        f"| with {hogs} hogs: error of a tick, ms | HAL p99.9, most | loop p99.9, most "
        f"| ratio of p99.9 (aim, real-time: {AIM}) |",
        "|---|---|---|---|",
    ]
    for one in found:
        cells = [f"{e.p999_ms:.2f}, {e.most_ms:.2f}" for e in (one.hal, one.loop)]
        rows.append(f"| HAL: {one.priority} priority | {cells[0]} | {cells[1]} | {one.ratio:.2f} |")
    return "\n".join(rows)


def main() -> int:
    """Measure and print; 1 if the aim is missed."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.jitter",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="of each of the two parts")
    parser.add_argument("--hogs", type=int, default=os.cpu_count() or 2)
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put the table into docs/speed.md")
    args = parser.parse_args()
    found = []
    for priority in PRIORITIES:
        print(f"bench.jitter: {priority}, {args.seconds:g} s", file=sys.stderr)
        with tempfile.TemporaryDirectory() as folder:
            found.append(measure(priority, args.seconds, args.hogs, Path(folder)))
    text = table(found, args.hogs)
    if args.json:
        print(json.dumps([asdict(one) | {"ratio": one.ratio} for one in found], indent=2))
    else:
        print(text)
    if args.write:
        print(f"written: {write_table('jitter', text)}", file=sys.stderr)
    return 0 if found[-1].ratio <= AIM else 1


if __name__ == "__main__":
    raise SystemExit(main())
