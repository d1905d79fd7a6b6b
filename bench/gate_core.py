"""How long the gate's core takes: rows against limits, rows along their path, and whole steps.

A C++ program with the gate's own code does the timing, all cases in turn, so that what the machine
does to one it does to the other; of each the quickest of many batches counts. Beside each case
stands a yardstick timed in the same run: it copies the chunk's numbers and compares each with two
bounds and with the row before. Instructions (--json) are counted by valgrind, and do not depend on
how busy the machine is.

    .venv/bin/python -m bench.gate_core [--config robots/panda_mobile/gate.sim.json] [--json]
    .venv/bin/python -m bench.gate_core --write
    .venv/bin/python -m bench.gate_core --worst 120 [--write]

Prints two tables, aims beside them; --write puts the second into docs/speed.md. Whole steps are
64 rows from received to encoded bytes: joint targets for all joints of the rows above, and the
robot's own chunks for every part of it. Times are the processor's; --json has the clock's as well.

--worst searches for chunks of a hostile policy that keep the gate busy for longest, for so many
seconds of processor's time each shipped gate file (or the one that --config names), and prints
what it found.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

from bench.page import Write, write_table
from fairlead.paths import gate_binary, gate_config, repo_root

ROBOT = "panda_mobile"
TARGET = "fairlead-safety-bench"
AIMS_NS = {
    "limits H=1": 10.0,
    "limits H=16": 100.0,
    "limits H=50": 350.0,
    "all checks H=1": 1_500.0,
    "all checks H=16": 16 * 1_500.0,
    "all checks H=50": 50 * 1_500.0,
}
STEP_AIM_NS = 200_000.0
STEP_TIMES = ("p50_ns", "p999_ns")
COLLECTED = re.compile(r"Collected : (\d+)")
FEW, MANY = 100, 1100


@dataclass(frozen=True)
class Timed:
    """One case: quickest and median batch [ns a call], and instructions a call if counted."""

    name: str
    least_ns: float
    median_ns: float
    yardstick_ns: float
    instructions: int | None

    @property
    def ratio(self) -> float:
        """How many yardsticks of the same length it takes."""
        return self.least_ns / self.yardstick_ns


class Program:
    """The timing program, built when needed."""

    def __init__(self, config: Path, counts: bool) -> None:
        self.config = config
        self.counts = counts
        build = [str(repo_root() / "scripts" / "build-gate"), "--target", TARGET]
        subprocess.run(build, check=True, stdout=subprocess.DEVNULL)
        self.binary = gate_binary().with_name(TARGET)

    def timings(self, rounds: int, ticks: int) -> dict[str, Any]:
        """What it prints: cases and whole steps, times in ns."""
        return self._run("--rounds", str(rounds), "--ticks", str(ticks))

    def _run(self, *options: str) -> dict[str, Any]:
        words = [str(self.binary), str(self.config), *options]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"bench/gate_core: {done.stderr.strip()}")
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    def worst_step(self, seconds: float) -> dict[str, Any]:
        """The slowest step that a search of so many seconds finds; times in us."""
        return self._run("--worst", str(seconds))

    def instructions(self, case: str) -> int | None:
        """Instructions of one call; None without valgrind, or if they are not asked for."""
        if not self.counts or shutil.which("valgrind") is None:
            return None
        few, many = self._collected(case, FEW), self._collected(case, MANY)
        return round((many - few) / (MANY - FEW))

    def _collected(self, case: str, calls: int) -> int:
        words = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        words += [str(self.binary), str(self.config), "--case", case, "--calls", str(calls)]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        found = COLLECTED.search(done.stderr)
        assert found is not None, done.stderr
        return int(found.group(1))


def timed_cases(program: Program, cases: dict[str, dict[str, float]]) -> list[Timed]:
    """Every case but the yardsticks, each with the yardstick of its length."""
    found = []
    for name, times in cases.items():
        length = name.rsplit(" ", 1)[1]
        if name.startswith("yardstick"):
            continue
        yardstick = cases[f"yardstick {length}"]["least_ns"]
        count = program.instructions(name)
        found.append(Timed(name, times["least_ns"], times["median_ns"], yardstick, count))
    return sorted(found, key=lambda one: (one.name.split(" H=")[0], one.least_ns))


def digits(ns: float) -> str:
    """Three of them at least."""
    return f"{ns:.1f}" if ns < 100.0 else f"{ns:.0f}"


def rows_table(found: dict[str, Any]) -> str:
    """The cases in Markdown: a line for those that differ only in their number of rows."""
    lines: dict[str, dict[str, str]] = {}
    for one in sorted(found["cases"], key=lambda one: float(one["least_ns"])):
        kind, _, rows = one["name"].partition(" H=")
        aim = f" (< {AIMS_NS[one['name']]:.0f})" if one["name"] in AIMS_NS else ""
        lines.setdefault(kind, {})[rows] = f"{digits(one['least_ns'])}{aim}"
    lengths = list(next(iter(lines.values())))
    return "\n".join(
        [
            f"| rows of {found['joints']} joints, {found['pairs']} pairs: least ns (aim) "
            f"| {' | '.join(f'H={rows}' for rows in lengths)} |",
            "|---" * (1 + len(lengths)) + "|",
            *(
                f"| {kind} | {' | '.join(cells[rows] for rows in lengths)} |"
                for kind, cells in lines.items()
            ),
        ]
    )


def two_times(spread: dict[str, dict[str, float]]) -> str:
    """Processor time [us]: median, and of a thousand steps the slowest."""
    return ", ".join(f"{spread['busy'][key] / 1e3:.0f}" for key in STEP_TIMES)


def _rare(spread: dict[str, dict[str, float]]) -> float:
    """Of a thousand steps the slowest."""
    return spread["busy"][STEP_TIMES[-1]]


def steps_table(found: dict[str, Any]) -> str:
    """The whole steps in Markdown: of those that differ only in what their rows do the slowest."""
    kinds: dict[str, list[dict[str, Any]]] = {}
    for name, steps in found["steps"].items():
        kinds.setdefault(name.rpartition(", rows that ")[0], []).append(steps)
    lines = {
        kind: [
            two_times(max((steps[event] for steps in every), key=_rare))
            for event in ("chunk", "state")
        ]
        for kind, every in kinds.items()
    }
    return "\n".join(
        [
            f"| {found['rows']} rows, {found['ticks']} times: p50, p99.9 us "
            f"(aim < {STEP_AIM_NS / 1e3:.0f}) | chunk | state |",
            "|---|---|---|",
            *(f"| {kind} | {' | '.join(cells)} |" for kind, cells in lines.items()),
            f"| *control* | {two_times(found['control'])} | |",
        ]
    )


def worst_text(found: dict[str, dict[str, Any]]) -> str:
    """The slowest steps in words, each with the gate file that it is of."""
    said = []
    for what, key in (("a chunk", "chunk"), ("a state", "state"), ("all claims in a tick", "tick")):
        config, one = max(found.items(), key=lambda item: float(item[1][f"{key}_us"]))
        said.append(f"{what} {one[f'{key}_us'] / 1e3:.1f} ms ({config})")
    return fill(f"Slowest: {', '.join(said)}.", 120)


def search_worst(configs: list[Path], seconds: float) -> dict[str, dict[str, Any]]:
    """By gate file, relative to the repository, what `Program.worst_step` finds."""
    return {
        os.path.relpath(config, repo_root()): Program(config, False).worst_step(seconds)
        for config in configs
    }


def report_worst(arguments: argparse.Namespace) -> None:
    """Search, print, write."""
    shipped = sorted((repo_root() / "robots").glob("*/gate.*.json"))
    found = search_worst([arguments.config] if arguments.config else shipped, arguments.worst)
    if arguments.write:
        write_table("worst", worst_text(found))
    print(json.dumps(found, indent=2) if arguments.json else worst_text(found))


def parse_arguments() -> argparse.Namespace:
    """What the command was given."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--config", type=Path, help=f"gate file (default: {ROBOT}, sim)")
    parser.add_argument("--rounds", type=int, default=300, help="batches of each case")
    parser.add_argument("--ticks", type=int, default=10000, help="whole steps of each kind")
    parser.add_argument("--worst", type=float, metavar="SECONDS", help="only the slowest step")
    parser.add_argument("--no-instructions", action="store_true", help="do not count them")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put it into docs/speed.md")
    return parser.parse_args()


def report_times(arguments: argparse.Namespace) -> None:
    """Time, count, print, write."""
    config = arguments.config or gate_config(ROBOT, "sim")
    program = Program(config, not arguments.no_instructions)
    load_before = os.getloadavg()[0]
    found = program.timings(arguments.rounds, arguments.ticks)
    load_after = os.getloadavg()[0]
    cases = timed_cases(program, found["cases"])
    found["cases"] = [vars(one) | {"ratio": one.ratio} for one in cases]
    found["load_average"] = [load_before, load_after]
    found["config"] = os.path.relpath(config, repo_root())
    tables = {"core": rows_table(found), "steps": steps_table(found)}
    if arguments.write:
        write_table("steps", tables["steps"])
    if arguments.json:
        print(json.dumps(found, indent=2))
    else:
        note = f"load average {load_before:.1f} before, {load_after:.1f} after; {found['config']}"
        print("\n\n".join([*tables.values(), note]))


def main() -> None:
    """Build, then what was asked for."""
    arguments = parse_arguments()
    (report_worst if arguments.worst else report_times)(arguments)


if __name__ == "__main__":
    main()
