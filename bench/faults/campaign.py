"""Runs rows of the fault matrix, one injection after the other, with the control beside each."""

from __future__ import annotations

import os
import queue
import statistics
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.faults.row import MachineLateError, NotHereError, Row, Shot
from bench.faults.stages import STAGES
from bench.faults.timer_process import TimerProcess
from fairlead.errors import FairleadError

RETRIES = 2
"""How many injections, of each wanted one, may be lost to a machine that was too late itself."""


@dataclass
class RowResult:
    """What all injections of a row showed.

    measured_ms: of the injections that count. machine_late: injections that missed the bound
    by less than the control process was late in the same stretch of time: not counted.
    not_here: why this machine does not permit the row.
    """

    row: Row
    measured_ms: list[float] = field(default_factory=list)
    control_ms: list[float] = field(default_factory=list)
    tick_ms: list[float] = field(default_factory=list)
    also: list[float] = field(default_factory=list)
    counted: int = 0
    machine_late: int = 0
    failures: list[str] = field(default_factory=list)
    not_here: str = ""
    notes: list[str] = field(default_factory=list)
    wall_s: float = 0.0
    load: float = 0.0

    @property
    def passed(self) -> bool:
        """Every injection that counts had the right outcome within the bound."""
        return self.counted > 0 and not self.failures

    def take(self, shot: Shot, control_ms: list[float]) -> None:
        """Count an injection, unless the machine itself was too late for it."""
        self.control_ms += control_ms
        bound, measured = self.row.bound_ms, shot.measured_ms
        if bound is not None and measured is not None and measured > bound:
            if self.row.excused and measured - bound <= max(control_ms):
                self.machine_late += 1
                return
            self.failures.append(
                f"{measured:.1f} ms, bound {bound:g} ms; control at most {max(control_ms):.1f} ms"
            )
        self.counted += 1
        self.notes.append(shot.note)
        if measured is not None:
            self.measured_ms.append(measured)
        if shot.tick_ms is not None:
            self.tick_ms.append(shot.tick_ms)
        if shot.also is not None:
            self.also.append(shot.also)

    def entry(self) -> dict[str, Any]:
        """As data."""
        return {
            "row": self.row.number, "fault": self.row.fault, "outcome": self.row.outcome,
            "bound_ms": self.row.bound_ms, "measures": self.row.measures,
            "n": self.counted, "machine_late": self.machine_late,
            "p50_ms": _middle(self.measured_ms), "max_ms": max(self.measured_ms, default=None),
            "also": self.row.also, "also_p50": _middle(self.also),
            "also_max": max(self.also, default=None),
            "control_p50_ms": _middle(self.control_ms),
            "control_max_ms": max(self.control_ms, default=None),
            "tick_max_ms": max(self.tick_ms, default=None),
            "load": round(self.load, 1),
            "measured": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
            "passed": self.passed, "not_here": self.not_here, "failures": self.failures,
            "notes": self.notes, "wall_s": round(self.wall_s, 1),
        }  # fmt: skip


def _middle(values: Sequence[float]) -> float | None:
    return statistics.median(values) if values else None


class Campaign:
    """One after the other, on stages that stay open while their rows run.

    Args:
        folder: gets a folder for each stage that is opened.
        say: called with each line of progress.
    """

    def __init__(self, folder: Path, timer: TimerProcess, say: Callable[[str], None]) -> None:
        self._folder, self._timer, self._say = folder, timer, say
        self._opened = 0
        self._stage: tuple[str, AbstractContextManager[Any], Any] | None = None

    def run(self, row: Row, injections: int | None) -> RowResult:
        """All injections of a row; never raises for what the robot did."""
        result, wanted = RowResult(row), injections or row.times
        began = time.monotonic()
        for _ in range(wanted * (1 + RETRIES)):
            if result.counted + len(result.failures) >= wanted or len(result.failures) >= 3:
                break
            if result.not_here:
                return result
            self._inject(row, result)
        if not result.counted and not result.failures:
            result.failures.append("the machine was too late each time")
        result.wall_s, result.load = time.monotonic() - began, os.getloadavg()[0]
        return result

    def close(self) -> None:
        """End the stage that is open."""
        if self._stage is not None:
            _, context, _ = self._stage
            self._stage = None
            context.__exit__(None, None, None)

    def _inject(self, row: Row, result: RowResult) -> None:
        try:
            shot = row.inject(self._on(row.stage))
            result.take(shot, self._timer.late_ms(shot.began_ns, shot.ended_ns))
        except NotHereError as error:
            result.not_here = str(error)
            self._say(f"  row {row.number}: not here: {error}")
            return
        except MachineLateError as error:
            result.machine_late += 1
            self._say(f"  row {row.number}: machine late: {error}")
            self.close()
            return
        except (AssertionError, FairleadError, OSError, TimeoutError, queue.Empty) as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            text = f"{type(error).__name__} in {where.name}:{where.lineno}: {error}"
            result.failures.append(text[:2000])
            self._say(f"  row {row.number}: FAILED: {text[:600]}")
            self._close_after()
            return
        measured = "" if shot.measured_ms is None else f"{shot.measured_ms:.1f} ms "
        self._say(f"  row {row.number}: {measured}{shot.note}".rstrip())

    def _on(self, stage: str) -> Any:
        if self._stage is None or self._stage[0] != stage:
            self.close()
            self._opened += 1
            folder = self._folder / f"{self._opened:02d}-{stage}"
            folder.mkdir(parents=True)
            context = STAGES[stage](folder)
            self._stage = (stage, context, context.__enter__())
        return self._stage[2]

    def _close_after(self) -> None:
        """A robot that failed may be in any state: the next injection gets a new one."""
        try:
            self.close()
        except (AssertionError, FairleadError, OSError) as other:
            self._say(f"  and while closing: {other}")
