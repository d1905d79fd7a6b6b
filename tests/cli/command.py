"""Runs ``fairlead`` as a user does: as a process of its own, with its own state root.

What talks to nobody is also run within the test's process, which saves the time that Python
needs to start.
"""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from unittest import mock

from bench.equipment.terminal import Terminal
from fairlead_tools.cli.main import main

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
    return [sys.executable, "-m", "fairlead_tools.cli.main", *arguments]


def terminal(state: Path, *arguments: str) -> Terminal:
    """Run one command in a terminal of its own."""
    return Terminal(fairlead_command(*arguments), fairlead_environment(state) | {"TERM": "xterm"})


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


def fairlead_here(*arguments: str, state: Path) -> subprocess.CompletedProcess[str]:
    """The same without a process: for commands that read files, or that are refused."""
    command = ["fairlead", *arguments]
    out, err, code = io.StringIO(), io.StringIO(), 0
    mask = os.umask(0o022)
    heard = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    with (
        mock.patch.dict(os.environ, fairlead_environment(state)),
        mock.patch.object(sys, "argv", command),
        mock.patch.multiple(os, execv=_refuse_to_leave, execvpe=_refuse_to_leave),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as end:
            assert end.code is None or isinstance(end.code, int), end
            code = end.code or 0
        finally:  # one that was about to end hears no signal any more, nor would its children
            for number, handler in heard.items():
                signal.signal(number, handler)
            os.umask(mask)
    return subprocess.CompletedProcess(command, code, out.getvalue(), err.getvalue())


def _refuse_to_leave(*_: object) -> None:
    raise AssertionError("this command becomes another program: run it as a process")
