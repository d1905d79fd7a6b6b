"""``python -m bench.days``: records the days of services/safety/test/corpus anew."""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.days.choice import choose
from bench.days.day import Day, read_day, write_days
from bench.days.decision_log import HEADER_BYTES, config_text, read_log
from bench.days.runs import run_everything
from fairlead.paths import decisions_binary, repo_root

CORPUS = repo_root() / "services/safety/test/corpus"
MOST_BYTES = {"panda_mobile": 1_000_000, "panda": 250_000, "dual_panda": 230_000}
DAY_BYTES = 150_000
DEMO_BYTES = 300_000


def main() -> int:
    """Record, choose, write; 1 if a robot has no day."""
    chosen = _arguments().parse_args()
    with tempfile.TemporaryDirectory(prefix="fairlead-days-") as made:
        folder = chosen.logs or Path(made)
        if not chosen.choose:
            run_everything(folder)
        return _write(folder)


def _write(folder: Path) -> int:
    missing = 0
    CORPUS.mkdir(exist_ok=True)
    logs = sorted(folder.rglob("*.decisions"))
    for robot, most_bytes in MOST_BYTES.items():
        text = (repo_root() / _config_of(robot)).read_text(encoding="utf-8")
        days = list(_days(logs, folder, text))
        if not days:
            print(f"days: no log under {folder} is of {robot} as it is now", file=sys.stderr)
            missing = 1
            continue
        demo = [day for day in days if day.name.startswith("demo/")]
        kept = _choose_true(robot, text, days, demo, most_bytes)
        write_days(CORPUS / f"{robot}.decisions", _config_of(robot), text, kept, "recorded")
        names = "".join(f"{day.name}\n" for day in kept)
        (CORPUS / f"{robot}.days").write_text(names, encoding="utf-8")
        shown = len(frozenset().union(*(day.shows for day in kept)))
        most = len(frozenset().union(*(day.shows for day in days)))
        steps = sum(len(day.records) for day in kept)
        print(f"{robot}: {len(kept)} of {len(days)} days, {steps} steps, {shown} of {most} kinds")
    return missing


def _config_of(robot: str) -> str:
    return f"robots/{robot}/gate.sim.json"


def _days(logs: list[Path], folder: Path, text: str) -> list[Day]:
    days = []
    known: set[str] = set()
    for log in logs:
        name = str(log.relative_to(folder))
        records = read_log(log, HEADER_BYTES)
        if not records or config_text(records) != text:
            continue
        most = DEMO_BYTES if name.startswith("demo/") else DAY_BYTES
        day = read_day(log, name, text, most)
        if day is not None and (mark := _mark(day)) not in known:
            known.add(mark)
            days.append(day)
    return days


def _mark(day: Day) -> str:
    return hashlib.sha256(b"".join(record.frame for record in day.records)).hexdigest()


def _choose_true(
    robot: str, text: str, days: list[Day], always: list[Day], most_bytes: int
) -> list[Day]:
    """Chosen days, without those whose log is not what the gate answers: some tests make such."""
    while True:
        kept = choose(days, always, most_bytes)
        false = [day for day in kept if not _is_true(robot, text, day)]
        if not false:
            return kept
        print("days: not what this gate answers:", *(day.name for day in false), file=sys.stderr)
        days = [day for day in days if day not in false]
        always = [day for day in always if day not in false]


def _is_true(robot: str, text: str, day: Day) -> bool:
    with tempfile.TemporaryDirectory(prefix="fairlead-day-") as folder:
        log = Path(folder) / "one.decisions"
        write_days(log, _config_of(robot), text, [day], "recorded")
        command = [str(decisions_binary()), "judge", str(log)]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bench.days",
        description="Runs real robots and gates, and keeps what their gates were given and what "
        "they answered as the recorded days of services/safety/test/corpus.",
        epilog="example: python -m bench.days --logs /tmp/days; "
        "python -m bench.days --choose --logs /tmp/days",
    )
    parser.add_argument("--logs", type=Path, help="empty folder that keeps what the runs wrote")
    parser.add_argument("--choose", action="store_true", help="run nothing: choose from --logs")
    return parser


if __name__ == "__main__":
    sys.exit(main())
