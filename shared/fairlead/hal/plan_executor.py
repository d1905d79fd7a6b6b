"""Carries out a decided tick, or holds instead, and records what the robot really did."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError
from fairlead.hal.backend import Backend, NotCarriedOutError, TraceSource
from fairlead.hal.core import TickPlan
from fairlead.hal.identity import HalIdentity, HostSettings
from fairlead.hal.inbox import SharedCore
from fairlead.hal.lease_follower import LEASE_LIFE_NS
from fairlead.hal.status_and_stops import StopPublisher
from fairlead.line_writer import LineWriter
from fairlead.messages import Acted, FloatArray, Hold
from fairlead.reason_text import reason_of


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


class PlanExecutor:
    """Exactly one step of the backend per plan; whatever prevents it is a hold and logged.

    Args:
        identity: names the robot's parts, in its order, and checks what they are told.
        log: gets one line per decided tick, and another where it was held after all.
        trace: shows the simulator's state before each step; None: it is not recorded.
        clock: monotonic nanoseconds.
    """

    def __init__(
        self,
        backend: Backend,
        settings: HostSettings,
        identity: HalIdentity,
        core: SharedCore,
        stops: StopPublisher,
        log: MotionLog,
        trace: TraceSource | None,
        clock: Callable[[], int],
    ) -> None:
        self._backend = backend
        self._parts, self._check = identity.parts, identity.commands.check
        self._core = core
        self._stops = stops
        self._log = log
        self._trace = trace
        self._clock = clock
        self._lockstep = settings.lockstep
        self._decided_ns = 0

    def record(self, plan: TickPlan, now_ns: int, event: str | None) -> None:
        """Log the decision, taken at ``now_ns``, before it is carried out."""
        self._decided_ns = now_ns
        self._log.tick(plan.tick, now_ns, plan.acted, event, plan.lease_ns)

    def carry_out(self, plan: TickPlan) -> None:
        """Step the backend once, with the plan's commands or, where that fails, holding."""
        before = self._trace.generalized_state() if self._trace else None
        commands = {self._parts[part]: command for part, command in plan.commands.items()}
        try:
            for name, command in commands.items():
                self._check(name, command)
            if not self._lockstep and self._clock() - self._decided_ns > LEASE_LIFE_NS:
                # This process was stopped since it decided: the row's time has passed.
                commands = {}
                self.void(plan.tick, Hold.LEASE_STALE, "held instead: paused after the decision")
            self._backend.apply(commands)
        except NotCarriedOutError as error:
            self.void(plan.tick, Hold.NO_ROW, f"held instead: {reason_of(error)}")
        except ConfigError as error:
            self._hold_instead(plan.tick, reason_of(error), is_row=bool(commands))
        if self._trace is not None and before is not None:
            self._log.trace(plan.tick, self._trace.packed(), *before)

    def void(self, tick: int, hold: Hold, event: str) -> None:
        """Every part held in ``tick``, whatever had been decided; the log says so too."""
        self._core.change(lambda core: core.void(hold))
        acted, lease_ns = self._core.read(lambda core: (core.acted, core.leases.received_ns))
        self._log.tick(tick, self._clock(), acted, event, lease_ns)

    def _hold_instead(self, tick: int, reason: str, *, is_row: bool) -> None:
        """The backend refused what it was told: stop, and hold this tick."""
        told = "a released command" if is_row else "to hold"
        self._stops.raise_stop(f"the backend refused {told}: {reason}")
        self.void(tick, Hold.STOPPED, f"held instead: {reason}")
        with suppress(NotCarriedOutError):
            self._backend.apply({})


_LOG = logging.getLogger("hal.fault")


STANDS_S = 0.3
BRAKE_S = 2.0
"""How long a HAL that ends may hold before it lets go; who asked kills it after 3 s or more."""


class FaultHold:
    """Commands every part's hold law to a backend that has failed, or that is let go.

    A driver that raised once (a bus that recovered) may well carry out a hold, and the
    robot must not be left with its last command.

    Attributes:
        commanded: holds the backend has taken.
        failed: holds the backend has refused.
    """

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self._failing = False
        self._said: set[str] = set()
        self.commanded = 0
        self.failed = 0

    @property
    def detail(self) -> str:
        """What the last attempt came to, for the status."""
        if self._failing:
            return "the hold cannot be commanded"
        return "held" if self.commanded else "hold not yet commanded"

    def command(self) -> None:
        """One attempt; never raises, and says only what changed."""
        try:
            self._backend.apply({})
        except Exception as error:  # noqa: BLE001 - a driver may raise anything; try again
            self.failed += 1
            if not self._failing:
                _LOG.error("the hold cannot be commanded: %s", reason_of(error))
            self._failing = True
            return
        self.commanded += 1
        if self._failing:
            _LOG.warning("the hold is commanded again, after %d failures", self.failed)
        self._failing = False

    def brake(self, is_still: Callable[[], bool], period_s: float) -> None:
        """Hold until the robot has been measured to stand for `STANDS_S`, for `BRAKE_S` at most.

        Longer than one measurement: what was told last may not have begun. A robot that cannot be
        measured is told to hold all that time.
        """
        ends_s, stands_s = time.monotonic() + BRAKE_S, 0.0
        while True:
            is_so = False
            with suppress(Exception):
                is_so = is_still()
            self.command()
            stands_s = stands_s + period_s if is_so else 0.0
            if stands_s >= STANDS_S or time.monotonic() + period_s > ends_s:
                return
            time.sleep(period_s)

    def beside(self, step: Callable[[], None]) -> None:
        """Do what the next hold must not fail by; whatever it raises is said once a type."""
        try:
            step()
        except Exception as error:  # noqa: BLE001 - the robot's hold goes on whatever this was
            if type(error).__name__ not in self._said:
                self._said.add(type(error).__name__)
                _LOG.exception("beside the hold")
