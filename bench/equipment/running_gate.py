"""The real gate as a process of a test."""

from __future__ import annotations

import queue
import re
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from bench.equipment.mailbox import DEADLINE_S
from fairlead.paths import gate_binary
from fairlead_tools.supervisor.this_host import free_ports

ROBOT = "panda_mobile"
STAMP = re.compile(r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z (?=INFO|WARNING)")


class RunningGate:
    """One gate process; ``lines`` are those it has printed so far, without their time.

    Args:
        listen: an endpoint; empty: a free port of this host.
    """

    def __init__(
        self,
        config: Path,
        state_dir: Path,
        *options: str,
        robot: str = ROBOT,
        port: int | None = None,
        connect: Sequence[int] = (),
        router: str = "",
        listen: str = "",
    ) -> None:
        self.port = free_ports(1)[0] if port is None else port
        self.endpoint = listen or f"tcp/127.0.0.1:{self.port}"
        self.lines: list[str] = []
        words = [str(gate_binary()), "--robot", robot, "--config", str(config)]
        words += ["--state-dir", str(state_dir), *options]
        words += ["--router", router] if router else ["--listen", self.endpoint]
        for other in connect:
            words += ["--connect", f"tcp/127.0.0.1:{other}"]
        self.process = subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self._queue: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as output:
            for line in output:
                self._queue.put(STAMP.sub("", line.rstrip("\n")))
        self._queue.put(None)

    def wait_line(self, text: str) -> str:
        """The first new line that contains ``text``."""
        deadline = time.monotonic() + DEADLINE_S
        while True:
            line = self._queue.get(timeout=max(0.0, deadline - time.monotonic()))
            assert line is not None, f"no line with {text!r}; it printed {self.lines}"
            self.lines.append(line)
            if text in line:
                return line

    def new_lines(self) -> list[str]:
        """What it has printed since somebody last read."""
        new: list[str] = []
        while not self._queue.empty():
            line = self._queue.get()
            assert line is not None, f"it ended; it printed {self.lines}"
            new.append(line)
        self.lines += new
        return new

    def wait_exit(self) -> int:
        """Its exit status; ``lines`` is then complete."""
        status = self.process.wait(DEADLINE_S)
        while (line := self._queue.get(timeout=DEADLINE_S)) is not None:
            self.lines.append(line)
        self._reader.join(DEADLINE_S)
        return status

    def stop(self) -> int:
        """Ask it to end."""
        self.process.send_signal(signal.SIGTERM)
        return self.wait_exit()

    def kill(self) -> None:
        """End it without asking."""
        self.process.kill()
        self.wait_exit()

    def close(self) -> None:
        """Leave nothing behind, whatever the test did."""
        if self.process.poll() is None:
            self.kill()
