"""One process of a deployment: start it, read what it prints, end it with its children."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import IO

from fairlead.deploy.process_table import ProcessId, group_members, process_id
from fairlead.log_stamp import stamped
from fairlead_tools.supervisor.die_with_parent import die_with_parent
from fairlead_tools.supervisor.service_log import ServiceLog

LineHandler = Callable[[str, str], None]
"""Gets the service's name and one line it printed."""

LAST_LINES = 15  # enough for a Python error's last frames


class Child:
    """A running process in a process group of its own (so Ctrl-C reaches us first).

    Args:
        name: the service's name.
        command: what to execute.
        environment: its whole environment.
        log: the file its lines are appended to.
        on_line: called from a thread for every line.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        log: Path,
        on_line: LineHandler,
    ) -> None:
        self.name = name
        self.ready = threading.Event()
        self.last_lines: deque[str] = deque(maxlen=LAST_LINES)
        self._on_line = on_line
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment,
            start_new_session=True,
            preexec_fn=die_with_parent(),
        )
        self.process_id = process_id(self._process.pid) or ProcessId(self._process.pid, 0)
        assert self._process.stdout is not None
        self._reader = threading.Thread(
            target=self._read,
            args=(self._process.stdout, ServiceLog(log)),
            name=f"{name}-log",
            daemon=True,
        )
        try:
            self._reader.start()
        except RuntimeError:  # no thread to be had: nobody would read what it prints
            self._process.kill()
            self._process.wait()
            raise

    @property
    def pid(self) -> int:
        """Process id, also after the process has ended."""
        return self._process.pid

    @property
    def exit_status(self) -> int | None:
        """None while it runs; negative: the signal that ended it."""
        return self._process.poll()

    def ask_to_stop(self) -> None:
        """SIGTERM to the process; it ends its own children. A stopped one is woken first."""
        if self.exit_status is None:
            self._process.terminate()
            self._process.send_signal(signal.SIGCONT)

    def kill_group(self) -> None:
        """SIGKILL to the process and everything it started that is still there."""
        if group_members(self.pid):
            with suppress(ProcessLookupError):  # the last of them has just ended
                os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()
        self._reader.join(timeout=1.0)

    def wait(self, timeout_s: float) -> bool:
        """Whether the process has ended within ``timeout_s``."""
        try:
            self._process.wait(max(timeout_s, 0.0))
        except subprocess.TimeoutExpired:
            return False
        return True

    def _read(self, stream: IO[bytes], log: ServiceLog) -> None:
        with stream, closing(log):
            for raw in stream:
                line = raw.decode(errors="replace").rstrip()
                self.last_lines.append(line)
                if is_ready_line(line):
                    self.ready.set()
                self._on_line(self.name, line)
                trouble = log.append(stamped(line, self.name))
                if trouble:
                    self._on_line(self.name, trouble)


def is_ready_line(line: str) -> bool:
    """Whether a service says that it is up: ``ready`` (gate), ``INFO hal: ready`` (Python)."""
    return line == "ready" or line.endswith(": ready")
