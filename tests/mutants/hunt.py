"""Running the tests against one mutant after the other."""

from __future__ import annotations

import os
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

HANG_MS = 3000  # processor time beyond what its tests take, after which a mutant counts as hung
QUICK_S = 0.2  # tests that together take no longer are tried first


class Fate(Enum):
    """What became of a mutant."""

    KILLED = "killed"
    TIMED_OUT = "timed out"
    SURVIVED = "survived"
    NOT_REACHED = "not reached"


@dataclass(frozen=True)
class TestCase:
    """A test case as the program without a mutant ran it."""

    name: str
    seconds: float
    reached: frozenset[int]

    @property
    def pattern(self) -> str:
        """The name as doctest's filter takes it: a comma would end it."""
        return re.sub(r'[,"\\]', "?", self.name)


def run(program: Path, mutant: int, tests: list[TestCase], **env: str) -> int:
    """The program's exit status; negative: the signal that ended it."""
    budget = HANG_MS + int(3000 * sum(test.seconds for test in tests))
    names = ",".join(test.pattern for test in tests)
    return subprocess.run(
        [program, "--abort-after=1", "--minimal", *([f"--test-case={names}"] if names else [])],
        env=os.environ | {"FAIRLEAD_MUTANT": str(mutant), "FAIRLEAD_MUTANT_MS": str(budget)} | env,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        timeout=1800,
    ).returncode


def reach(program: Path) -> list[TestCase]:
    """Every test case with the mutants it comes by; the first is what the constants came by."""
    report = program.with_name("reached.tsv")
    subprocess.run(
        [program, "--minimal"],
        env=os.environ | {"FAIRLEAD_MUTANT_MAP": str(report)},
        check=True,
        timeout=1800,
    )
    cases = []
    for line in report.read_text().splitlines():
        name, seconds, ids = line.split("\t")
        cases.append(TestCase(name, float(seconds), frozenset(map(int, ids.split()))))
    return cases


def fate_of(program: Path, mutant: int, tests: list[TestCase]) -> Fate:
    """Run the tests that reach the mutant, the quick ones first, until one fails."""
    if not tests:
        return Fate.NOT_REACHED
    ordered = sorted(tests, key=lambda test: test.seconds)
    quick: list[TestCase] = []
    while ordered and sum(test.seconds for test in quick) + ordered[0].seconds <= QUICK_S:
        quick.append(ordered.pop(0))
    for chosen in (quick, ordered):
        status = run(program, mutant, chosen) if chosen else 0
        if status == -27:  # SIGPROF
            return Fate.TIMED_OUT
        if status != 0:
            return Fate.KILLED
    return Fate.SURVIVED


def hunt(program: Path, wanted: dict[int, str], jobs: int) -> dict[int, Fate]:
    """The fate of each mutant; ``wanted`` says which file each is of."""
    start, *cases = reach(program)
    home = {}  # a file's constants are read before any test: every test of that file counts
    for file in set(wanted.values()):
        ids = {mutant for mutant, name in wanted.items() if name == file}
        home[file] = [case for case in cases if case.reached & ids]

    def one(mutant: int) -> tuple[int, Fate]:
        tests = [case for case in cases if mutant in case.reached]
        if not tests and mutant in start.reached:
            tests = home[wanted[mutant]]
        return mutant, fate_of(program, mutant, tests)

    with ThreadPoolExecutor(jobs) as pool:
        return dict(pool.map(one, wanted))
