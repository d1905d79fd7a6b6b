"""``python -m bench.recorded_sessions.judged``: sessions that a second mind judged alike."""

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

from bench.equipment.real_gate import LOGS
from bench.recorded_sessions.__main__ import CORPUS
from bench.recorded_sessions.choice import choose
from bench.recorded_sessions.decision_log import BOOT, END, HEADER, LogRecord, config_text, read_log
from bench.recorded_sessions.session import Session, shown, write_sessions

TESTS = ("tests/differential", "-k", "not with_one_other_limit")
MOST_BYTES, LOOKED_AT, FEW = 120_000, 1_500, 20


def main() -> int:
    """Judge, choose, write; 1 if gate and reference do not agree."""
    options = _arguments().parse_args()
    with tempfile.TemporaryDirectory(prefix="fairlead-judged-") as made:
        folder = options.logs or Path(made)
        if not options.choose and _judge(folder) != 0:
            print("sessions: gate and reference differ, nothing is written", file=sys.stderr)
            return 1
        _write(folder)
    return 0


def _judge(folder: Path) -> int:
    environment = dict(os.environ, **{LOGS: str(folder)})
    command = [sys.executable, "-m", "pytest", "-q", "-x", "--no-header", *TESTS]
    return subprocess.run(command, env=environment, check=False).returncode


def _write(folder: Path) -> None:
    by_config: dict[str, list[Session]] = defaultdict(list)
    for log in sorted(folder.rglob("*.decisions")):
        for session in _sessions(log):
            by_config[session.config].append(session)
    CORPUS.mkdir(exist_ok=True)
    for old in CORPUS.glob("judged_*.decisions"):
        old.unlink()
    numbers: dict[str, int] = defaultdict(int)
    for text, sessions in by_config.items():
        if len(sessions) < FEW:
            continue
        robot = json.loads(text)["robot"]
        numbers[robot] += 1
        name = f"judged_{robot}_{numbers[robot]}"
        some = random.Random(1).sample(sessions, min(len(sessions), LOOKED_AT))
        kept = choose(some, [], MOST_BYTES)
        write_sessions(CORPUS / f"{name}.decisions", "gate.json", text, kept, "judged")
        print(f"{name}: {len(kept)} of {len(sessions)} sessions")


def _sessions(log: Path) -> Iterator[Session]:
    """From boot to boot, but the first, whose ids are two gates', and the last, maybe cut off."""
    header, *records = read_log(log) or [LogRecord(END, b"")]
    if header.type != HEADER:
        return
    text = config_text([header])
    starts = [at for at, record in enumerate(records) if record.type == BOOT][1:]
    for number, (start, end) in enumerate(pairwise(starts)):
        session = records[start:end]
        yield Session(f"{log.name} {number:06}", text, tuple(session), frozenset(shown(session)))


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bench.recorded_sessions.judged",
        description="Runs tests/differential and keeps what the gate's core was given there and "
        "what it answered, if its reference agreed to all of it, as services/safety/test/corpus/"
        "judged_*.decisions.",
        epilog="example: python -m bench.recorded_sessions.judged --logs /tmp/judged; "
        "python -m bench.recorded_sessions.judged --choose --logs /tmp/judged",
    )
    parser.add_argument("--logs", type=Path, help="empty folder that keeps what the runs wrote")
    parser.add_argument("--choose", action="store_true", help="run nothing: choose from --logs")
    return parser


if __name__ == "__main__":
    sys.exit(main())
