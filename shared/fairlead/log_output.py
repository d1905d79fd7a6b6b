"""Log lines on standard output, from a thread of its own: a reader that stops reading stops nobody.

A supervisor that is paused, as by Ctrl-Z, reads nothing; a service that waited for it would hang.
"""

from __future__ import annotations

import logging
import os
import queue
import sys
import threading
from contextlib import suppress

from fairlead.wire.printable import LineFormatter

MOST_QUEUED = 1000
"""Lines; more are left out, and the next one that has room says how many."""
LAST_WORDS_S = 0.2


class LogOutput(logging.Handler):
    """Queues lines for standard output, or standard error where that was closed."""

    def __init__(self) -> None:
        super().__init__()
        self.setFormatter(LineFormatter())
        self._lines: queue.Queue[str] = queue.Queue(MOST_QUEUED)
        self._left_out = 0
        stream = sys.stdout or sys.stderr
        if stream is not None:
            # Past Python's own output, whose lock would be held while nobody reads.
            threading.Thread(
                target=self._write, args=(stream.fileno(),), name="log", daemon=True
            ).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Queue one line; the logger holds this handler's lock."""
        try:
            line = self.format(record)
        except Exception:  # noqa: BLE001 - as the library's own handlers
            self.handleError(record)
            return
        if self._left_out:
            line += f" ({self._left_out} lines left out before)"
        try:
            self._lines.put_nowait(line)
        except queue.Full:
            self._left_out += 1
        else:
            self._left_out = 0

    def flush(self) -> None:
        """Have what is queued written, for at most `LAST_WORDS_S`."""
        written = self._lines.all_tasks_done
        with written:
            written.wait_for(lambda: not self._lines.unfinished_tasks, LAST_WORDS_S)

    def _write(self, descriptor: int) -> None:
        while True:
            data = f"{self._lines.get()}\n".encode(errors="backslashreplace")
            with suppress(OSError):  # nobody reads any more, or a full disk behind a redirection
                while data:
                    data = data[os.write(descriptor, data) :]
            self._lines.task_done()


def flush_log() -> None:
    """Before a line that is printed past the log, or the end of a process that ends at once."""
    for handler in logging.getLogger().handlers:
        handler.flush()
