"""The gate on coverage: every line and every branch of the gate's core is run by its C++ tests.

    python -m bench.core_coverage            builds with gcov, runs the tests, prints a table
    python -m bench.core_coverage --again    only reads what the last run left

Branches that only an exception takes are left out: nothing in the core throws. A line that no test
can reach carries ``GCOVR_EXCL_LINE`` or ``GCOVR_EXCL_BR_LINE`` and behind it the reason; the
reviewed list is what ``grep -rn GCOVR services/safety`` finds.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SAFETY = ROOT / "services/safety"
BUILD = Path(os.environ.get("FAIRLEAD_COVERAGE_BUILD", ROOT / "build/coverage"))
TESTS = "fairlead-safety-tests"
FLOOR = {"lines": 100.0, "branches": 100.0}
CONDITION = re.compile(r"\b(if|for|while|switch)\b|\?|&&|\|\||[<>=!]=| [<>] ")
WITH_REASON = re.compile(r"// GCOVR_EXCL_(?:BR_)?LINE: \w+")


@dataclass(frozen=True)
class Line:
    """One executable line: how often it ran, and which of its branches were taken."""

    file: str
    number: int
    count: int
    branches: tuple[int, ...]

    @property
    def missing(self) -> str:
        """What of it no test has run, "" if nothing."""
        if self.count == 0:
            return "never run"
        untaken = sum(taken == 0 for taken in self.branches)
        return f"{untaken} of {len(self.branches)} branches never taken" if untaken else ""

    def merged(self, other: Line) -> Line:
        """Both together: a template's line, counted once for each type.

        gcov may know that a copy ran, but not its branches, and nothing of the copy it knows.
        """
        one, two = sorted((self, other), key=lambda line: line.count)
        if one.count == 0 and not two.branches:
            return two
        pairs = itertools.zip_longest(self.branches, other.branches, fillvalue=0)
        branches = tuple(a + b for a, b in pairs)
        return Line(self.file, self.number, self.count + other.count, branches)


def build_and_run() -> None:
    """The tests, instrumented, from a clean count."""
    gate = [ROOT / "scripts/build-gate", "--tests", "--target", TESTS, "--build-dir", BUILD]
    subprocess.run([*map(str, gate), "--", "-DFAIRLEAD_SAFETY_COVERAGE=ON"], check=True)
    for old in BUILD.rglob("*.gcda"):
        old.unlink()
    subprocess.run([BUILD / TESTS, "--minimal"], check=True, timeout=900)


def read_lines() -> list[Line]:
    """What gcov counted, for the core and its public headers."""
    report = BUILD / "coverage.json"
    gcovr: list[str | Path] = [Path(sys.executable).with_name("gcovr"), "--root", SAFETY]
    gcovr += [BUILD, "-j", "2"]
    gcovr += ["--filter", f"{SAFETY}/src/core/", "--filter", f"{SAFETY}/include/"]
    gcovr += ["--exclude-throw-branches", "--merge-mode-functions", "separate", "--json", report]
    gcovr += ["--gcov-ignore-errors", "source_not_found"]  # of what was there at an earlier build
    subprocess.run([str(word) for word in gcovr], check=True, timeout=600)
    found: dict[tuple[str, int], Line] = {}
    for file in json.loads(report.read_text())["files"]:
        text = (SAFETY / file["file"]).read_text().splitlines()
        for line in file["lines"]:
            if not line.get("gcovr/excluded"):
                known = [one for one in line["branches"] if not one.get("gcovr/excluded")]
                counts = tuple(branch["count"] for branch in known)
                if not CONDITION.search(text[line["line_number"] - 1]):
                    counts = ()  # the edge of an exception that gcov does not call one
                here = Line(file["file"], line["line_number"], line["count"], counts)
                place = here.file, here.number
                found[place] = here.merged(found[place]) if place in found else here
    return [one_statement(line, found) for line in found.values()]


def one_statement(line: Line, found: dict[tuple[str, int], Line]) -> Line:
    """A line that gcov counts with the next one, to which its statement goes on, and not itself."""
    text = (SAFETY / line.file).read_text().splitlines()[line.number - 1].split("//")[0].rstrip()
    after = found.get((line.file, line.number + 1))
    if line.count or line.branches or after is None or text.endswith((";", "{", "}", ":")):
        return line
    return replace(line, count=after.count)


def percent(part: int, whole: int) -> float:
    """Share in percent; of nothing, all."""
    return 100.0 * part / whole if whole else 100.0


def print_table(lines: list[Line]) -> dict[str, float]:
    """A row for each file and the total; returns the total."""
    print(f"{'file':44}{'lines':>14}{'branches':>16}")
    total = {}
    for name in [*sorted({line.file for line in lines}), "total"]:
        here = [line for line in lines if name in (line.file, "total")]
        ran = sum(line.count > 0 for line in here)
        branches = [taken for line in here for taken in line.branches]
        taken = sum(count > 0 for count in branches)
        total = {"lines": percent(ran, len(here)), "branches": percent(taken, len(branches))}
        print(f"{name:44}{f'{ran}/{len(here)}':>14}{f'{taken}/{len(branches)}':>16}")
    return total


def unexplained_exclusions() -> list[str]:
    """Exclusions in the sources that give no reason."""
    return [
        f"{path.relative_to(ROOT)}:{number}"
        for folder in ("src/core", "include")
        for path in sorted((SAFETY / folder).rglob("*.?pp"))
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if "_EXCL_" in line and not WITH_REASON.search(line)
    ]


def main() -> int:
    """The exit status: 0 if the floor holds."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.core_coverage",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--again", action="store_true", help="read what the last run left")
    if not parser.parse_args().again:
        build_and_run()
    lines = read_lines()
    for line in lines:
        if line.missing:
            text = (SAFETY / line.file).read_text().splitlines()[line.number - 1].strip()
            print(f"services/safety/{line.file}:{line.number}: {line.missing}: {text}")
    total = print_table(lines)
    print(f"lines {total['lines']:.2f} %, branches {total['branches']:.2f} %")
    unexplained = unexplained_exclusions()
    for place in unexplained:
        print(f"{place}: an exclusion without a reason")
    low = [kind for kind, floor in FLOOR.items() if total[kind] < floor]
    for kind in low:
        print(f"FAILED: {kind} below {FLOOR[kind]} %: write a test that tells that story")
    return 1 if low or unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
