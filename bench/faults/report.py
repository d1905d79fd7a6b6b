"""What a campaign found, as text for a terminal and as the list of docs/faults.md.

The list is made from `RESULTS`, which keeps what was measured last of each row: so a few rows
can be measured again without the others.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping, Sequence
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

from bench.faults.campaign import RowResult
from bench.faults.row import Row
from bench.faults.table import ROWS
from fairlead.paths import repo_root

PAGE = repo_root() / "docs" / "faults.md"
RESULTS = Path(__file__).with_name("results.json")
BEGIN, END = "<!-- begin: make faults ARGS=--write -->", "<!-- end -->"
WIDTH = 120
TOLD = ("hold", "stop", "stop to hold")
"""What says how soon the robot brakes: the list leaves other times out."""
Entry = Mapping[str, Any]


def summary(results: Sequence[RowResult]) -> str:
    """One line a row, and every failure in full."""
    lines = []
    for result in results:
        entry = result.entry()
        lines.append(
            f"{result.row.number:3d} {_verdict(entry):6s} {result.row.fault}: "
            f"n {result.counted}, p50 {_ms(entry['p50_ms'])}, max {_ms(entry['max_ms'])} "
            f"(bound {_ms(result.row.bound_ms)}), control {_ms(entry['control_p50_ms'])} / "
            f"{_ms(entry['control_max_ms'])}, {result.wall_s:.0f} s"
        )
        lines += [f"      {failure}" for failure in result.failures]
    passed = sum(result.passed for result in results)
    return "\n".join([*lines, f"{passed} of {len(results)} passed"])


def keep(entries: Sequence[Entry], file: Path = RESULTS) -> None:
    """Replace what is known of these rows; forget rows that do not exist any more."""
    known = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else []
    merged = {_key(entry): entry for entry in (*known, *entries)}
    order = {(row.number, row.fault): place for place, row in enumerate(ROWS)}
    kept = sorted((key for key in merged if key in order), key=order.__getitem__)
    text = json.dumps([merged[key] for key in kept], indent=1)
    file.write_text(f"{text.replace(str(Path.home()), '/~')}\n", encoding="utf-8")


def document(file: Path = RESULTS) -> str:
    """The list: rows as measured last, and those that are not run."""
    known = {_key(entry): entry for entry in json.loads(file.read_text(encoding="utf-8"))}
    days = sorted(str(entry["measured"])[:10] for entry in known.values())
    span = f"on {days[0]}" if days[0] == days[-1] else f"from {days[0]} to {days[-1]}"
    done = [known[key] for row in ROWS if (key := (row.number, row.fault)) in known]
    passed = sum(_verdict(entry) == "passed" for entry in done)
    times, late = (sum(int(entry[name]) for entry in done) for name in ("n", "machine_late"))
    unmeasured = _forms([row for row in ROWS if (row.number, row.fault) not in known])
    summed = (
        f"{passed} of {len(ROWS)} faults passed, done {times} times ({late} more on a late "
        f"machine) {span}, at a load of at most {_most(done, 'load')}."
    )
    lines = [_wrapped(summed), "", *map(_wrapped, _lines(done))]
    return "\n".join([*lines, *map(_wrapped, unmeasured)])


def current_page() -> str:
    """docs/faults.md with the list as it has to be now between its marks."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    assert rest and after, f"{PAGE}: no markers"
    return f"{before}{BEGIN}\n{document()}\n{END}{after}"


def _key(entry: Entry) -> tuple[int, str]:
    return int(entry["row"]), str(entry["fault"])


def _wrapped(line: str) -> str:
    indent = "  " if line.startswith("- ") else ""
    return textwrap.fill(
        line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def _lines(entries: Sequence[Entry]) -> list[str]:
    """One line a number; its forms that have the same outcome and the same bound are one."""
    forms: dict[tuple[Any, ...], list[Entry]] = {}
    for entry in entries:
        bound = _is_told(entry) and (entry["measures"], entry["bound_ms"])
        key = (entry["row"], _verdict(entry), entry["outcome"], bound)
        forms.setdefault(key, []).append(entry)
    numbers: dict[int, list[Sequence[Entry]]] = {}
    for same in forms.values():
        numbers.setdefault(int(same[0]["row"]), []).append(same)
    return [
        f"- {number}: {' '.join(_said(*two) for two in pairwise([[], *every]))}"
        for number, every in numbers.items()
    ]


def _is_told(entry: Entry) -> bool:
    return entry["bound_ms"] is not None and entry["measures"] in TOLD


def _said(before: Sequence[Entry], same: Sequence[Entry]) -> str:
    """Of its times the longest of any form."""
    entry = same[0]
    said = _failure(entry) + _outcome(same)
    faults = _together([one["fault"] for one in same], before[-1]["fault"] if before else "")
    return f"**{faults}.** {said[0].upper()}{said[1:]}."


def _outcome(same: Sequence[Entry]) -> str:
    """With the longest time behind it, or behind the word that says what was measured."""
    entry = same[0]
    outcome, measures = str(entry["outcome"]), str(entry["measures"]).removeprefix("stop to ")
    if not _is_told(entry):
        return outcome
    time = f"{_most(same, 'max_ms')}/{_ms(entry['bound_ms'])}"
    said, ends, more = outcome.partition(";")
    return f"{said} {time}{ends}{more}" if said == measures else f"{outcome}; {measures} {time}"


def _forms(rows: Sequence[Row]) -> list[str]:
    """The lines of rows that were never measured, one a number."""
    forms: dict[int, list[str]] = {}
    for row in rows:
        forms.setdefault(row.number, []).append(row.fault)
    return [f"- {number}: **{_first_of(every)}.** Not measured." for number, every in forms.items()]


def _first_of(faults: Sequence[str]) -> str:
    return f"{faults[0]}; {len(faults) - 1} more" if len(faults) > 1 else faults[0]


def _together(faults: Sequence[str], before: str) -> str:
    """The forms of a fault; what one and the form before, or the first, begin with is said once."""
    head = _briefly(before, faults[0], "")
    return "; ".join([head, *(_briefly(*two, faults[0]) for two in pairwise(faults))])


def _briefly(before: str, fault: str, first: str) -> str:
    also = fault.removeprefix(first)
    if also != fault:
        return f"also with {also.strip(', ')}"
    words = zip(fault.split(), before.split(), strict=False)
    return fault.removeprefix(
        "".join(f"{a} " for a, _ in takewhile(lambda two: two[0] == two[1], words))
    )


def _most(entries: Sequence[Entry], name: str) -> str:
    return _ms(max(entry[name] or 0.0 for entry in entries))


def _failure(entry: Entry) -> str:
    """What stands before the outcome of a row that did not pass."""
    verdict = _verdict(entry)
    return "" if verdict == "passed" else f"**{verdict}**: "


def _verdict(entry: Entry) -> str:
    if entry["not_here"]:
        return f"not run: {entry['not_here']}"
    return "passed" if entry["passed"] else "FAILED"


def _ms(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"
