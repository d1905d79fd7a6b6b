"""What a campaign found, as text for a terminal and as the table of docs/faults.md.

The table is made from `RESULTS`, which keeps what was measured last of each row: so a few rows
can be measured again without the others.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from bench.faults.campaign import RowResult
from bench.faults.row import Row
from bench.faults.table import ROWS
from fairlead.paths import repo_root

PAGE = repo_root() / "docs" / "faults.md"
RESULTS = Path(__file__).with_name("results.json")
BEGIN, END = "<!-- begin: make faults ARGS=--write -->", "<!-- end -->"
TIMED = ("row", "fault", "outcome", "time and bound", "most")
UNTIMED = ("row", "fault", "outcome")
LATER = ("row", "fault", "why")
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
    file.write_text(f"{text}\n", encoding="utf-8")


def document(file: Path = RESULTS) -> str:
    """The tables: rows with a time and without, as measured last, and those that are not run."""
    known = {_key(entry): entry for entry in json.loads(file.read_text(encoding="utf-8"))}
    days = sorted(str(entry["measured"]) for entry in known.values())
    done = [known[key] for row in ROWS if (key := (row.number, row.fault)) in known]
    passed = sum(_verdict(entry) == "passed" for entry in done)
    lines = _lines(done)
    times, late = (sum(int(entry[name]) for entry in done) for name in ("n", "machine_late"))
    unmeasured = _forms([row for row in ROWS if (row.number, row.fault) not in known])
    return "\n".join(
        [
            f"Measured from {days[0]} to {days[-1]} on a machine of two cores; times are in ms.",
            f"{passed} of {len(ROWS)} faults passed, done {times} times ({late} more on a late "
            f"machine); {len(ROWS) - len(done)} are not measured yet. Of all: control p50 at most "
            f"{_most(done, 'control_p50_ms')}, max "
            f"{_most(done, 'control_max_ms')}; HAL tick {_most(done, 'tick_max_ms')}; load "
            f"{_most(done, 'load')}.",
            "",
            *_table(TIMED, [cells for cells in lines if len(cells) == len(TIMED)]),
            "",
            "Without a bound:",
            "",
            *_table(UNTIMED, [cells for cells in lines if len(cells) == len(UNTIMED)]),
            *(["", "Not measured yet:", "", *_table(LATER, unmeasured)] if unmeasured else []),
        ]
    )


def current_page() -> str:
    """docs/faults.md with the tables as they have to be now between its marks."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    assert rest and after, f"{PAGE}: no markers"
    return f"{before}{BEGIN}\n{document()}\n{END}{after}"


def _key(entry: Entry) -> tuple[int, str]:
    return int(entry["row"]), str(entry["fault"])


def _table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> list[str]:
    cells = [f"| {' | '.join(line)} |" for line in (head, *lines)]
    return [cells[0], "|---" * len(head) + "|", *cells[1:]]


def _lines(entries: Sequence[Entry]) -> list[list[str]]:
    """One line for the forms of a fault that have the same outcome and the same bound."""
    forms: dict[tuple[Any, ...], list[Entry]] = {}
    for entry in entries:
        bound = entry["bound_ms"] and (entry["measures"], entry["bound_ms"])
        key = (entry["row"], _verdict(entry), entry["outcome"], bound)
        forms.setdefault(key, []).append(entry)
    return [_line(same) for same in forms.values()]


def _line(same: Sequence[Entry]) -> list[str]:
    """The cells of one line: of its times the longest of any form."""
    entry = same[0]
    faults = _together([one["fault"] for one in same])
    cells = [str(entry["row"]), faults, _failure(entry) + entry["outcome"]]
    if entry["bound_ms"] is None:
        return cells
    bound = f"{entry['measures']} {_ms(entry['bound_ms'])}"
    most = _most(same, "max_ms")
    if all(one.get("also") == entry["also"] != "" for one in same):
        most += f"; {entry['also']} {_most(same, 'also_max')}"
    return [*cells, bound, most]


def _forms(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    """The lines of rows that were never measured, one a number."""
    forms: dict[int, list[str]] = {}
    for row in rows:
        forms.setdefault(row.number, []).append(row.fault)
    return [(f"{number}", _first_of(faults), "not measured") for number, faults in forms.items()]


def _first_of(faults: Sequence[str]) -> str:
    return f"{faults[0]}; {len(faults) - 1} more" if len(faults) > 1 else faults[0]


def _together(faults: Sequence[str]) -> str:
    """The forms of a fault; what all of them, or one and the first, begin with is said once."""
    first, *others = faults
    words = zip(*(fault.split() for fault in faults), strict=False)
    said = "".join(f"{same[0]} " for same in takewhile(lambda same: len(set(same)) == 1, words))
    return "; ".join([first, *(_briefly(other, first, said) for other in others)])


def _briefly(fault: str, first: str, said: str) -> str:
    also = fault.removeprefix(first)
    return fault.removeprefix(said) if also == fault else f"also with {also.strip(', ')}"


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
