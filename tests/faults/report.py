"""What a campaign found, as text for a terminal and as the table of docs/faults.md.

The table is made from `RESULTS`, which keeps what was measured last of each row: so a few rows
can be measured again without the others.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fairlead.paths import repo_root
from tests.faults.campaign import RowResult
from tests.faults.table import NOT_RUN, ROWS

DOCUMENT = repo_root() / "docs" / "faults.md"
RESULTS = Path(__file__).with_name("results.json")
BEGIN, END = "<!-- begin: make faults ARGS=--write -->", "<!-- end -->"
HEAD = (
    "| row | fault | outcome | time | bound | n | p50 | max | control |",
    "|---|---|---|---|---|---|---|---|---|",
)
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
    """Both tables: rows that are run, with what was measured last, and those that are not."""
    known = {_key(entry): entry for entry in json.loads(file.read_text(encoding="utf-8"))}
    days = sorted(str(entry["measured"]) for entry in known.values())
    done = [known[key] for row in ROWS if (key := (row.number, row.fault)) in known]
    passed = sum(_verdict(entry) == "passed" for entry in done)
    lines = []
    for row in ROWS:
        entry = known.get((row.number, row.fault))
        lines.append(
            _line(entry)
            if entry is not None
            else f"| {row.number} | {row.fault} | not measured yet: {row.outcome} |  "
            f"| {_ms(row.bound_ms)} | 0 | - | - | - |"
        )
    missing = [
        f"| {row.number} | {row.fault} | {row.reason} |"
        for row in sorted(NOT_RUN, key=lambda row: row.number)
    ]
    return "\n".join(
        [
            f"Measured from {days[0]} to {days[-1]} on a machine of two cores; times are in ms.",
            f"{passed} of {len(ROWS)} rows passed, {len(ROWS) - len(done)} are not measured yet. "
            f"Of all rows: control p50 at most {_most(done, 'control_p50_ms')}, HAL tick "
            f"{_most(done, 'tick_max_ms')}, load {_most(done, 'load')}.",
            "",
            *HEAD,
            *lines,
            "",
            "Rows that the campaign does not run:",
            "",
            "| row | fault | why, and where else |",
            "|---|---|---|",
            *missing,
        ]
    )


def write_document(text: str) -> None:
    """Put it between the markers of docs/faults.md."""
    before, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    assert rest and after, f"{DOCUMENT}: no markers"
    DOCUMENT.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")


def _key(entry: Entry) -> tuple[int, str]:
    return int(entry["row"]), str(entry["fault"])


def _line(entry: Entry) -> str:
    late = f" (+{entry['machine_late']} late machine)" if entry["machine_late"] else ""
    timed = entry["p50_ms"] is not None
    measures = entry["measures"] if timed else ""
    if entry.get("also"):
        measures += f"; {entry['also']}: {_ms(entry['also_p50'])} / {_ms(entry['also_max'])}"
    cells = [
        str(entry["row"]), entry["fault"], _failure(entry) + entry["outcome"],
        measures, _ms(entry["bound_ms"]), f"{entry['n']}{late}",
        _ms(entry["p50_ms"]), _ms(entry["max_ms"]), _ms(entry["control_max_ms"]),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


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
