"""``python -m bench.days.judged``: days of which a second mind said the same, recorded anew."""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from bench.days.__main__ import CORPUS
from bench.days.choice import choose
from bench.days.day import Day, shown, write_days
from bench.days.decision_log import BOOT, END, HEADER, LogRecord, config_text, read_log
from bench.equipment.real_gate import LOGS

TESTS = ("tests/differential", "-k", "not with_one_other_limit")
MOST_BYTES, LOOKED_AT, FEW = 120_000, 1_500, 20


def main() -> int:
    """Judge, choose, write; 1 if gate and reference do not agree."""
    options = _arguments().parse_args()
    with tempfile.TemporaryDirectory(prefix="fairlead-judged-") as made:
        folder = options.logs or Path(made)
        if not options.choose and _judge(folder) != 0:
            print("days: gate and reference differ, nothing is written", file=sys.stderr)
            return 1
        _write(folder)
    return 0


def _judge(folder: Path) -> int:
    environment = dict(os.environ, **{LOGS: str(folder)})
    command = [sys.executable, "-m", "pytest", "-q", "-x", "--no-header", *TESTS]
    return subprocess.run(command, env=environment, check=False).returncode


def _write(folder: Path) -> None:
    by_config: dict[str, list[Day]] = defaultdict(list)
    for log in sorted(folder.rglob("*.decisions")):
        for day in _days(log):
            by_config[day.config].append(day)
    CORPUS.mkdir(exist_ok=True)
    for old in CORPUS.glob("judged_*.decisions"):
        old.unlink()
    numbers: dict[str, int] = defaultdict(int)
    for text, days in by_config.items():
        if len(days) < FEW:
            continue
        robot = json.loads(text)["robot"]
        numbers[robot] += 1
        name = f"judged_{robot}_{numbers[robot]}"
        some = random.Random(1).sample(days, min(len(days), LOOKED_AT))
        kept = choose(some, [], MOST_BYTES)
        write_days(CORPUS / f"{name}.decisions", "gate.json", text, kept, "judged")
        print(f"{name}: {len(kept)} of {len(days)} days")


def _days(log: Path) -> Iterator[Day]:
    """From boot to boot, but the first, whose ids are two gates', and the last, maybe cut off."""
    header, *records = read_log(log) or [LogRecord(END, b"")]
    if header.type != HEADER:
        return
    text = config_text([header])
    starts = [at for at, record in enumerate(records) if record.type == BOOT][1:]
    for number, (start, end) in enumerate(pairwise(starts)):
        day = records[start:end]
        yield Day(f"{log.name} {number:06}", text, tuple(day), frozenset(shown(day)))


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bench.days.judged",
        description="Runs tests/differential and keeps what the gate's core was given there and "
        "what it answered, if its reference agreed to all of it, as services/safety/test/corpus/"
        "judged_*.decisions.",
        epilog="example: python -m bench.days.judged --logs /tmp/judged; "
        "python -m bench.days.judged --choose --logs /tmp/judged",
    )
    parser.add_argument("--logs", type=Path, help="empty folder that keeps what the runs wrote")
    parser.add_argument("--choose", action="store_true", help="run nothing: choose from --logs")
    return parser


if __name__ == "__main__":
    sys.exit(main())
