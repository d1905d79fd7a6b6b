"""The HAL's own record of what it did: ``motion.jsonl`` and, on request, ``trace.jsonl``.

A thread writes, so a slow or full disk never delays a tick; every line is handed to the
operating system as soon as it is queued, so a killed process loses nothing that its
writer had taken. A failed write is said once and ends that file's recording.
"""

from __future__ import annotations

import json
import logging
import queue
import threading
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fairlead.messages import Acted, FloatArray

_LOG = logging.getLogger("hal.motion_log")

MAX_QUEUED = 10_000
"""Lines waiting for a stuck disk before new ones are dropped (and counted)."""


class LineWriter:
    """Appends lines to one file from its own thread; never blocks, never raises.

    Attributes:
        dropped: lines that could not be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
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

    def _write(self) -> None:
        try:
            with self._path.open("a", encoding="ascii", buffering=1) as file:
                while (line := self._queue.get()) is not None:
                    file.write(line + "\n")
        except OSError as error:
            _LOG.error("%s: no longer recorded: %s", self._path, error.strerror)
            while self._queue.get() is not None:
                self.dropped += 1


class MotionLog:
    """One line per tick: when it was decided, by which lease, and what every part did."""

    def __init__(self, folder: Path, session: int, trace: bool) -> None:
        self._session = session
        self._motion = LineWriter(folder / "motion.jsonl")
        self._trace = LineWriter(folder / "trace.jsonl") if trace else None

    @property
    def traces(self) -> bool:
        """Whether `trace` records anything."""
        return self._trace is not None

    def tick(
        self, tick: int, stamp_ns: int, acted: Sequence[Acted], event: str | None, lease_ns: int
    ) -> None:
        """Record a decided tick.

        Args:
            stamp_ns: CLOCK_MONOTONIC at the decision.
            lease_ns: the same clock when the newest lease came; 0: none had.
        """
        self._motion.put(
            json.dumps(
                {
                    "tick": tick,
                    "session": self._session,
                    "stamp_ns": stamp_ns,
                    "acted": [[part.hold, part.verdict_id, part.row] for part in acted],
                    "event": event,
                    "lease_ns": lease_ns,
                }
            )
        )

    def trace(
        self, tick: int, packed: npt.NDArray[np.float32], qpos: FloatArray, qvel: FloatArray
    ) -> None:
        """Record what the simulator got (float32) and its state before it (float64)."""
        if self._trace is not None:
            self._trace.put(
                json.dumps(
                    {
                        "tick": tick,
                        "packed": packed.tobytes().hex(),
                        "qpos": qpos.tobytes().hex(),
                        "qvel": qvel.tobytes().hex(),
                    }
                )
            )

    def close(self) -> None:
        """Write what is queued, for a few seconds at most."""
        self._motion.close()
        if self._trace is not None:
            self._trace.close()
