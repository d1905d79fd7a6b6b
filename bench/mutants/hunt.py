"""Running the tests against one mutant after the other.

A server is the test program, started once: it forks for each test it is asked to run, which costs
a millisecond. Only what a mutant changes before the first test needs a start of its own.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from queue import SimpleQueue

HANG_MS = 1000  # processor time beyond what its tests take, after which a mutant counts as hung
NEAR = 6  # mutants before and after one, whose tests are tried first
ALONE = 16  # so many tests are tried one by one
SIGALRM, SIGPROF = 14, 27


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


def limit_ms(tests: list[TestCase]) -> int:
    """Processor time after which they hang."""
    return HANG_MS + int(5000 * sum(test.seconds for test in tests))


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


def start_server(program: Path) -> subprocess.Popen[str]:
    """The program, waiting for tests to run."""
    return subprocess.Popen(
        [program, "--minimal"],
        env=os.environ | {"FAIRLEAD_MUTANT_SERVE": "1"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def status_of_fork(
    server: subprocess.Popen[str], mutant: int, tests: list[TestCase]
) -> tuple[int, str]:
    """What tests in a fork of the server ended with, and the name of the last one that ran.

    Negative: the signal that ended it.
    """
    assert server.stdin and server.stdout
    names = ",".join(test.pattern for test in tests)
    server.stdin.write(f"{mutant} {limit_ms(tests)} {names}\n")
    server.stdin.flush()
    status, last = server.stdout.readline().rstrip("\n").split(" ", 1)
    return os.waitstatus_to_exitcode(int(status)), last


def status_of_start(program: Path, mutant: int, tests: list[TestCase]) -> tuple[int, str]:
    """The same in a process of its own, for what is computed before the first test."""
    limits = {"FAIRLEAD_MUTANT": str(mutant), "FAIRLEAD_MUTANT_MS": str(limit_ms(tests))}
    names = ",".join(test.pattern for test in tests)
    status = subprocess.run(
        [program, "--abort-after=1", "--minimal", f"--test-case={names}"],
        env=os.environ | limits,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        timeout=1800,
    ).returncode
    return status, tests[-1].name


def batches(tests: list[TestCase]) -> Iterator[list[TestCase]]:
    """The first ones by themselves, the others in ever bigger groups."""
    at = 0
    while at < len(tests):
        size = 1 if at < ALONE else at
        yield tests[at : at + size]
        at += size


def untold(count: int, mutant: int, fate: Fate) -> None:
    """Progress that nobody wants to see."""


@dataclass
class Hunt:
    """One program, its tests, and which test noticed which mutant."""

    program: Path
    wanted: dict[int, str]  # the file of each mutant asked for
    noticed: dict[int, str] = field(default_factory=dict)  # name of the test, now or in a past run

    def __post_init__(self) -> None:
        """See which tests come by which mutants."""
        self.start, *self.cases = reach(self.program)
        self.cases.sort(key=lambda case: case.seconds)
        self.often: dict[str, Counter[str]] = defaultdict(Counter)  # by file and test
        for mutant, test in self.noticed.items():
            if mutant in self.wanted:
                self.often[self.wanted[mutant]][test] += 1
        self.home = {}  # a file's constants are read before any test: every test of it counts
        for file in set(self.wanted.values()):
            ids = {mutant for mutant, name in self.wanted.items() if name == file}
            reading = [case for case in self.cases if case.reached & ids]
            self.home[file] = reading or self.cases  # a header of nothing but a constant

    def tests_of(self, mutant: int) -> list[TestCase]:
        """Tests that may notice it, the likeliest and quickest first.

        First those that noticed it or one nearby, then those that noticed others of its file,
        then by time.
        """
        tests = [case for case in self.cases if mutant in case.reached]
        if mutant in self.start.reached:
            tests = self.home[self.wanted[mutant]]
        near = sorted(range(mutant - NEAR, mutant + NEAR + 1), key=lambda one: abs(one - mutant))
        first = [self.noticed[one] for one in near if one in self.noticed]
        of_file = self.often[self.wanted[mutant]]
        return sorted(
            tests,
            key=lambda case: (
                first.index(case.name) if case.name in first else len(first),
                -of_file[case.name],
            ),
        )

    def fate_of(self, mutant: int, server: subprocess.Popen[str]) -> Fate:
        """Run the tests that reach the mutant until one fails."""
        tests = self.tests_of(mutant)
        for some in batches(tests):
            if mutant in self.start.reached:
                status, last = status_of_start(self.program, mutant, some)
            else:
                status, last = status_of_fork(server, mutant, some)
            if status != 0:
                self.noticed[mutant] = last
                self.often[self.wanted[mutant]][last] += 1
                return Fate.TIMED_OUT if status in (-SIGPROF, -SIGALRM) else Fate.KILLED
        self.noticed.pop(mutant, None)
        return Fate.SURVIVED if tests else Fate.NOT_REACHED

    def run(self, jobs: int, tell: Callable[[int, int, Fate], None] = untold) -> dict[int, Fate]:
        """The fate of each mutant; ``tell`` is called with how many are known, and the newest."""
        servers: SimpleQueue[subprocess.Popen[str]] = SimpleQueue()
        started = [start_server(self.program) for _ in range(jobs)]
        for server in started:
            servers.put(server)

        def one(mutant: int) -> tuple[int, Fate]:
            server = servers.get()
            try:
                return mutant, self.fate_of(mutant, server)
            finally:
                servers.put(server)

        try:
            fates = {}
            with ThreadPoolExecutor(jobs) as pool:
                for mutant, fate in pool.map(one, self.wanted):
                    fates[mutant] = fate
                    tell(len(fates), mutant, fate)
            return fates
        finally:
            for server in started:
                server.kill()
                server.communicate()


def hunt(program: Path, wanted: dict[int, str], jobs: int) -> dict[int, Fate]:
    """The fate of each mutant; ``wanted`` says which file each is of."""
    return Hunt(program, wanted).run(jobs)
