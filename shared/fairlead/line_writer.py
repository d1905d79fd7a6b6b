"""A file of lines that a full or stuck disk cannot make anybody wait for.

A thread writes, in UTF-8; every line is handed to the operating system as soon as it is queued, so
a killed process loses nothing that its writer had taken. A failed write is said once and ends
that file's recording. A full file becomes ``<name>.1``, and what had that name goes.
"""

from __future__ import annotations

import logging
import os
import queue
import threading
from pathlib import Path

_LOG = logging.getLogger("line_writer")

MAX_QUEUED = 10_000
"""Lines waiting for a stuck disk before new ones are dropped (and counted)."""


MOST_BYTES = 256 << 20
"""A file is full then: half of what it and the one before it may have."""


def set_aside(path: Path) -> None:
    """A full file becomes ``<name>.1``, in the place of what had that name."""
    path.replace(path.with_name(f"{path.name}.1"))


class LineWriter:
    """Appends lines to one file from its own thread; never blocks, never raises.

    Args:
        afresh: begin with an empty file.
        most_bytes: at which the file is set aside and another begun.

    Attributes:
        dropped: lines that could not be written.
    """

    def __init__(self, path: Path, *, afresh: bool = False, most_bytes: int = MOST_BYTES) -> None:
        self._path, self._most_bytes = path, most_bytes
        self._mode = "wb" if afresh else "ab"
        self._queue: queue.Queue[str | None] = queue.Queue(MAX_QUEUED)
        self.dropped = 0
        self._thread = threading.Thread(target=self._write, name=path.name, daemon=True)
        self._thread.start()

    def put(self, line: str) -> None:
        """Queue one line; dropped and counted where the disk is stuck."""
        try:
            self._queue.put_nowait(line)
        except queue.Full:
            if not self.dropped:
                _LOG.error("%s: the disk is stuck, lines are lost", self._path)
            self.dropped += 1

    def close(self, timeout_s: float = 2.0) -> None:
        """Write what is queued, for at most ``timeout_s``, and say what was lost."""
        if self.dropped:
            _LOG.error("%s: %d lines were lost", self._path, self.dropped)
        try:
            self._queue.put(None, timeout=timeout_s)
        except queue.Full:
            return
        self._thread.join(timeout_s)

    def _fill_file(self) -> bool:
        """Write what comes; True when the file is full, False at the end."""
        with self._path.open(self._mode) as file:
            size = file.seek(0, os.SEEK_END) if file.seekable() else 0
            while (line := self._queue.get()) is not None:
                size += file.write(f"{line}\n".encode(errors="backslashreplace"))
                file.flush()
                if size >= self._most_bytes:
                    return True
        return False

    def _write(self) -> None:
        try:
            while self._fill_file():
                set_aside(self._path)
                self._mode = "ab"
        except Exception as error:  # noqa: BLE001 - a recording never ends without a word
            why = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
            _LOG.error("%s: no longer recorded: %s", self._path, why)
            while self._queue.get() is not None:
                self.dropped += 1
