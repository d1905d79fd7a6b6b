"""The HAL's own record of what it did: ``motion.jsonl`` and, on request, ``trace.jsonl``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fairlead.line_writer import LineWriter
from fairlead.messages import Acted, FloatArray


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
