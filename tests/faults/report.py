"""What a campaign found, as text for a terminal and as the table of docs/faults.md."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from fairlead.paths import repo_root
from tests.faults.campaign import RowResult
from tests.faults.table import NOT_RUN

DOCUMENT = repo_root() / "docs" / "faults.md"
BEGIN, END = "<!-- begin: make faults ARGS=--write -->", "<!-- end -->"
HEAD = (
    "| row | fault | outcome | time | bound | n | p50 | max | control p50 / max | HAL tick | |",
    "|---|---|---|---|---|---|---|---|---|---|---|",
)


def summary(results: Sequence[RowResult]) -> str:
    """One line a row, and every failure in full."""
    lines = []
    for result in results:
        entry = result.entry()
        lines.append(
            f"{result.row.number:3d} {_verdict(result):6s} {result.row.fault}: "
            f"n {result.counted}, p50 {_ms(entry['p50_ms'])}, max {_ms(entry['max_ms'])} "
            f"(bound {_ms(result.row.bound_ms)}), control {_ms(entry['control_p50_ms'])} / "
            f"{_ms(entry['control_max_ms'])}, {result.wall_s:.0f} s"
        )
        lines += [f"      {failure}" for failure in result.failures]
    passed = sum(result.passed for result in results)
    return "\n".join([*lines, f"{passed} of {len(results)} passed"])


def document(results: Sequence[RowResult], machine: str) -> str:
    """The table between the markers."""
    stamp = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    missing = [
        f"| {row.number} | {row.fault} | {row.reason} |"
        for row in sorted(NOT_RUN, key=lambda row: row.number)
    ]
    return "\n".join(
        [
            f"Measured {stamp}; {machine}. Times are in ms.",
            "",
            *HEAD,
            *(_line(result) for result in results),
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


def _line(result: RowResult) -> str:
    row, entry = result.row, result.entry()
    late = f" (+{result.machine_late} late machine)" if result.machine_late else ""
    cells = [
        str(row.number), row.fault, row.outcome, row.measures if row.bound_ms else "",
        _ms(row.bound_ms), f"{result.counted}{late}", _ms(entry["p50_ms"]), _ms(entry["max_ms"]),
        f"{_ms(entry['control_p50_ms'])} / {_ms(entry['control_max_ms'])}",
        _ms(entry["tick_max_ms"]), _verdict(result),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _verdict(result: RowResult) -> str:
    if result.not_here:
        return f"not run: {result.not_here}"
    return "passed" if result.passed else "FAILED"


def _ms(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"
