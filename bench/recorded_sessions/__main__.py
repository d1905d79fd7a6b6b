"""``python -m bench.recorded_sessions``: records services/safety/test/corpus anew."""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.recorded_sessions.choice import choose
from bench.recorded_sessions.decision_log import HEADER_BYTES, config_text, read_log
from bench.recorded_sessions.runs import run_everything
from bench.recorded_sessions.session import Session, read_session, write_sessions
from fairlead.paths import decisions_binary, repo_root

CORPUS = repo_root() / "services/safety/test/corpus"
MOST_BYTES = {"panda_mobile": 1_000_000, "panda": 250_000, "dual_panda": 230_000}
SESSION_BYTES = 150_000
DEMO_BYTES = 300_000


def main() -> int:
    """Record, choose, write; 1 if a robot has no session."""
    chosen = _arguments().parse_args()
    with tempfile.TemporaryDirectory(prefix="fairlead-sessions-") as made:
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
        sessions = list(_sessions(logs, folder, text))
        if not sessions:
            print(f"sessions: no log under {folder} is of {robot} as it is now", file=sys.stderr)
            missing = 1
            continue
        demo = [session for session in sessions if session.name.startswith("demo/")]
        kept = _choose_true(robot, text, sessions, demo, most_bytes)
        write_sessions(CORPUS / f"{robot}.decisions", _config_of(robot), text, kept, "recorded")
        names = "".join(f"{session.name}\n" for session in kept)
        (CORPUS / f"{robot}.sessions").write_text(names, encoding="utf-8")
        shown = len(frozenset().union(*(session.shows for session in kept)))
        most = len(frozenset().union(*(session.shows for session in sessions)))
        steps = sum(len(session.records) for session in kept)
        print(
            f"{robot}: {len(kept)} of {len(sessions)} sessions, {steps} steps, "
            f"{shown} of {most} kinds"
        )
    return missing


def _config_of(robot: str) -> str:
    return f"robots/{robot}/gate.sim.json"


def _sessions(logs: list[Path], folder: Path, text: str) -> list[Session]:
    sessions = []
    known: set[str] = set()
    for log in logs:
        name = str(log.relative_to(folder))
        records = read_log(log, HEADER_BYTES)
        if not records or config_text(records) != text:
            continue
        most = DEMO_BYTES if name.startswith("demo/") else SESSION_BYTES
        session = read_session(log, name, text, most)
        if session is not None and (mark := _mark(session)) not in known:
            known.add(mark)
            sessions.append(session)
    return sessions


def _mark(session: Session) -> str:
    return hashlib.sha256(b"".join(record.frame for record in session.records)).hexdigest()


def _choose_true(
    robot: str, text: str, sessions: list[Session], always: list[Session], most_bytes: int
) -> list[Session]:
    """Without those whose log is not what the gate answers: some tests make such."""
    while True:
        kept = choose(sessions, always, most_bytes)
        false = [session for session in kept if not _is_true(robot, text, session)]
        if not false:
            return kept
        print(
            "sessions: not what this gate answers:",
            *(session.name for session in false),
            file=sys.stderr,
        )
        sessions = [session for session in sessions if session not in false]
        always = [session for session in always if session not in false]


def _is_true(robot: str, text: str, session: Session) -> bool:
    with tempfile.TemporaryDirectory(prefix="fairlead-session-") as folder:
        log = Path(folder) / "one.decisions"
        write_sessions(log, _config_of(robot), text, [session], "recorded")
        command = [str(decisions_binary()), "judge", str(log)]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m bench.recorded_sessions",
        description="Runs real robots and gates, and keeps what their gates were given and what "
        "they answered as the recorded sessions of services/safety/test/corpus.",
        epilog="example: python -m bench.recorded_sessions --logs /tmp/sessions; "
        "python -m bench.recorded_sessions --choose --logs /tmp/sessions",
    )
    parser.add_argument("--logs", type=Path, help="empty folder that keeps what the runs wrote")
    parser.add_argument("--choose", action="store_true", help="run nothing: choose from --logs")
    return parser


if __name__ == "__main__":
    sys.exit(main())
