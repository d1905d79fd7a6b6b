"""Where ``fairlead up`` prints: the terminal, its log, or the log alone."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

from fairlead.log_stamp import stamped
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.lost_output import forget_output
from fairlead_tools.supervisor.service_log import ServiceLog


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
        except OSError:  # a full disk behind a redirection: the logs have the line, or say so
            return

    def close(self) -> None:
        """Have nothing left that would fail to be written when the process ends."""
        try:
            sys.stdout.flush()
        except OSError:
            forget_output()

    def detach(self) -> None:
        """Close the output; what would still be printed there is appended to the log."""
        self._is_detached = True
        sys.stdout.flush()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        log = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(log, stream.fileno())
        os.close(log)
