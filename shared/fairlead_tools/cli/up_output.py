"""Where ``fairlead up`` prints: the terminal, its log, or the log alone."""

from __future__ import annotations

import os
import queue
import select
import signal
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

from fairlead.log_stamp import stamped
from fairlead.wire.printable import printable_lines
from fairlead_tools.cli.lost_output import forget_output
from fairlead_tools.supervisor.service_log import ServiceLog

MOST_LINES = 1000
"""That wait for a terminal which takes none; more are only in the logs."""
LAST_WORDS_S = 2.0


class UpOutput:
    """Where ``up`` prints: the terminal, until it is detached; its own lines in a log too.

    A thread of its own prints, as a terminal may take nothing for hours.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / "logs" / "up.log"
        self._log = ServiceLog(self._path)
        self._lines: queue.Queue[str | None] = queue.Queue(MOST_LINES)
        self._thread = threading.Thread(target=self._print, name="terminal", daemon=True)
        self._thread.start()

    def __call__(self, service: str, line: str) -> None:
        """Print a line of one service, or of ``up``."""
        if service == "up":
            self._log.append(stamped(f"INFO up: {line}", service))
        self._put(f"[{service}] {line}")

    def close(self) -> None:
        """Have nothing left that would fail to be written when the process ends."""
        with suppress(OSError):  # a full disk behind a redirection
            if self._ends():
                sys.stdout.flush()
                return
        forget_output()

    def detach(self) -> None:
        """Close the output; what would still be printed there is appended to the log."""
        if self._ends():
            sys.stdout.flush()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        log = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(log, stream.fileno())
        os.close(log)

    def _put(self, line: str) -> None:
        with suppress(queue.Full):
            if self._thread.is_alive():
                self._lines.put_nowait(line)

    def _ends(self) -> bool:
        """Have the last lines printed; whether the terminal took them."""
        until_s = time.monotonic() + LAST_WORDS_S
        with suppress(queue.Full):
            self._lines.put(None, timeout=LAST_WORDS_S)
        self._thread.join(max(0.0, until_s - time.monotonic()))
        return not self._thread.is_alive()

    def _print(self) -> None:
        while (line := self._lines.get()) is not None:
            try:
                _write(line)
            except BrokenPipeError:  # whoever read our output has gone: end as on Ctrl-C
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
                os.kill(os.getpid(), signal.SIGTERM)
            except OSError:  # a full disk behind a redirection: the logs have the line, or say so
                continue


def _write(line: str) -> None:
    """Past Python's own output, whose lock would be held for as long as the terminal is stuck."""
    data = f"{printable_lines(line)}\n".encode(errors="backslashreplace")
    while data:
        try:
            data = data[os.write(sys.stdout.fileno(), data) :]
        except BlockingIOError:  # others may have set the terminal so
            select.select([], [sys.stdout.fileno()], [])
