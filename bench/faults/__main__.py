"""``python -m bench.faults``: the campaign on the command line; ``make faults`` runs it."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

from bench.faults.campaign import Campaign, RowResult
from bench.faults.report import PAGE, current_page, keep, summary
from bench.faults.row import Row
from bench.faults.table import ROWS
from bench.faults.timer_process import TimerProcess
from bench.page import Write


def main() -> int:
    """Run what was asked for; 1 if a row failed."""
    chosen = _arguments().parse_args()
    rows = [row for row in ROWS if not chosen.row or row.number in chosen.row]
    if not rows:
        known = ", ".join(str(number) for number in sorted({row.number for row in ROWS}))
        print(f"faults: no row {chosen.row} is run here (valid: {known})", file=sys.stderr)
        return 2
    stages = list(dict.fromkeys(row.stage for row in rows))
    rows.sort(key=lambda row: (stages.index(row.stage), row.number))
    with tempfile.TemporaryDirectory(prefix="fairlead-faults-") as folder:
        results = _run(rows, chosen.injections, chosen.logs or Path(folder), chosen.write)
    results.sort(key=lambda result: ROWS.index(result.row))
    entries = [result.entry() for result in results]
    print(json.dumps(entries, indent=2) if chosen.json else summary(results))
    if chosen.results:
        chosen.results.write_text(json.dumps(entries, indent=1))
    return 0 if all(result.passed or result.not_here for result in results) else 1


def _run(rows: list[Row], injections: int | None, folder: Path, write: bool) -> list[RowResult]:
    """With ``write`` each row is in the table as soon as it is done."""
    results = []
    began = time.monotonic()
    with TimerProcess() as timer:
        campaign = Campaign(folder, timer, _say)
        try:
            for number, row in enumerate(rows, 1):
                _say(f"[{number}/{len(rows)}, {time.monotonic() - began:.0f} s] {row.number} "
                     f"{row.fault}")  # fmt: skip
                results.append(campaign.run(row, injections))
                _say(f"  -> {'passed' if results[-1].passed else 'FAILED'}")
                if write:
                    keep([results[-1].entry()])
                    PAGE.write_text(current_page(), encoding="utf-8")
        finally:
            campaign.close()
    return results


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bench.faults",
        description="Does every fault of docs/faults.md to real processes and measures what "
        "they do.",
        epilog="example: python -m bench.faults --row 1 --row 26 --injections 3",
    )
    parser.add_argument("--row", type=int, action="append", help="only this row; repeatable")
    parser.add_argument("--injections", type=int, help="per row; else 5, and 20 for tight bounds")
    parser.add_argument("--json", action="store_true", help="print the results as data")
    parser.add_argument("--results", type=Path, help="also write the results to this file")
    parser.add_argument("--logs", type=Path, help="empty folder that keeps what processes wrote")
    parser.add_argument("--write", action=Write, page=PAGE, help="rewrite the table of faults.md")
    return parser


if __name__ == "__main__":
    sys.exit(main())
