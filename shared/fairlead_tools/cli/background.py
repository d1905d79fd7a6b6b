"""``fairlead up --detach``: the same command again, in a session of its own, until it is ready."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import typer

from fairlead.deploy.registry import Registry
from fairlead.log_stamp import stamped
from fairlead_tools.cli.console import echo
from fairlead_tools.supervisor.service_log import ServiceLog

END_TIMEOUT_S = 15.0


def start_in_background(words: Sequence[str], name: str) -> None:
    """Run ``fairlead`` with ``words``, print what it says until it is ready, and leave it running.

    It is ready when it closes its output. Ctrl-C before that ends it.

    Raises:
        typer.Exit: it ended instead, having said why.
    """
    command = [sys.executable, "-m", "fairlead_tools.cli.main", *words]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True
    )
    assert process.stdout is not None
    try:
        _show(process.stdout)
    except KeyboardInterrupt:
        process.terminate()
        _show(process.stdout)
        process.wait(END_TIMEOUT_S)
        raise
    entry = Registry().find(name)
    if entry is None or entry.supervisor is None or entry.supervisor.pid != process.pid:
        raise typer.Exit(process.wait(END_TIMEOUT_S) or 1)
    echo(f"it runs in the background; stop it: fairlead down {name}")
    echo(f"its lines: fairlead logs -f -d {name}")


def _show(stream: IO[bytes]) -> None:
    for line in stream:
        echo(line.decode(errors="replace").rstrip())


class UpOutput:
    """Where ``up`` prints: the terminal, until it is detached; its own lines in a log too."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "logs" / "up.log"
        self._log = ServiceLog(self._path)
        self._is_detached = False

    def __call__(self, service: str, line: str) -> None:
        """Print a line of one service, or of ``up``."""
        if service == "up":
            self._log.append(stamped(f"INFO up: {line}", service))
        try:
            if not self._is_detached:
                echo(f"[{service}] {line}")
        except BrokenPipeError:  # whoever read our output has gone: end as on Ctrl-C
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            os.kill(os.getpid(), signal.SIGTERM)

    def detach(self) -> None:
        """Close the output; what would still be printed there is appended to the log."""
        self._is_detached = True
        sys.stdout.flush()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        log = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(log, stream.fileno())
        os.close(log)
