"""One row of the fault matrix: what is done to the robot, and what one injection showed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fairlead.errors import FairleadError

TIGHT_MS = 150.0
"""Rows with a bound up to this get more injections."""
INJECTIONS, INJECTIONS_TIGHT = 5, 20


class NotHereError(FairleadError):
    """This machine does not permit the fault; the text says why."""


class MachineLateError(FairleadError):
    """The robot held because the machine gave its processes no time: says nothing of the fault."""


@dataclass(frozen=True)
class Shot:
    """One injection whose outcome was right.

    measured_ms: from the injection to what the row promises; None: the row has no time.
    began_ns, ended_ns: CLOCK_MONOTONIC around it, for the control measurement.
    tick_ms: the longest undisturbed tick of the robot's HAL just before; None: no HAL of ours.
    note: what else was seen, for the reader of the log.
    also: a second number, what the row's `also` says; it has no bound.
    """

    measured_ms: float | None
    began_ns: int
    ended_ns: int
    tick_ms: float | None = None
    note: str = ""
    also: float | None = None


@dataclass(frozen=True)
class Row:
    """A fault and its promise.

    number: of the fault matrix; a fault with several forms has one row for each.
    measures: what the time is, in words: from where to where, on whose clock.
    stage: which robot it is done to, see `bench.faults.stages`.
    inject: does it once, asserts the outcome.
    injections: if neither 5 nor 20 are right.
    also: what a second number is, in words.
    excused: a machine that was itself too late excuses a miss of the bound; not where the late
        machine is the fault.
    """

    number: int
    fault: str
    outcome: str
    bound_ms: float | None
    stage: str
    inject: Callable[[Any], Shot]
    measures: str = "hold"
    injections: int | None = None
    also: str = ""
    excused: bool = True

    @property
    def times(self) -> int:
        """How often it is done if nobody says otherwise."""
        if self.injections is not None:
            return self.injections
        tight = self.bound_ms is not None and self.bound_ms <= TIGHT_MS
        return INJECTIONS_TIGHT if tight else INJECTIONS
