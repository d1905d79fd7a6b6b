"""Runs ``fairlead`` as a user does: as a process of its own, with its own state root."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TIMEOUT_S = 280.0


def fairlead_environment(state: Path) -> dict[str, str]:
    """The environment of a command whose registry is ``state``."""
    return os.environ | {
        "FAIRLEAD_STATE": str(state),
        "COLUMNS": "200",
        "TERM": "dumb",
        "NO_COLOR": "1",
    }


def fairlead_command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "fairlead.cli.main", *arguments]


def fairlead(*arguments: str, state: Path, answer: str = "") -> subprocess.CompletedProcess[str]:
    """Run one command to its end and capture what it prints."""
    return subprocess.run(
        fairlead_command(*arguments),
        env=fairlead_environment(state),
        input=answer,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
