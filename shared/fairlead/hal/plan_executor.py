"""Carries out a decided tick, or holds instead, and records what the robot really did."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Condition

from fairlead.errors import FairleadError
from fairlead.hal.backend import Backend
from fairlead.hal.core import HalCore
from fairlead.hal.host_settings import HostSettings
from fairlead.hal.lease_follower import LEASE_LIFE_NS
from fairlead.hal.motion_log import MotionLog
from fairlead.hal.stop_caller import StopCaller
from fairlead.hal.tick_plan import TickPlan
from fairlead.hal.trace_source import TraceSource
from fairlead.messages import Hold


class PlanExecutor:
    """Exactly one step of the backend per plan; whatever prevents it is a hold and logged.

    Args:
        parts: names of the robot's parts, in its order.
        changed: the lock and condition that guard the core.
        log: gets one line per decided tick, and another where it was held after all.
        trace: shows the simulator's state before each step; None: it is not recorded.
        clock: monotonic nanoseconds.
    """

    def __init__(
        self,
        backend: Backend,
        settings: HostSettings,
        parts: Sequence[str],
        core: HalCore,
        changed: Condition,
        stops: StopCaller,
        log: MotionLog,
        trace: TraceSource | None,
        clock: Callable[[], int],
    ) -> None:
        self._backend = backend
        self._parts = tuple(parts)
        self._core = core
        self._changed = changed
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
        if not self._lockstep and self._clock() - self._decided_ns > LEASE_LIFE_NS:
            # This process was stopped since it decided: the row's time has passed.
            commands = {}
            self.void(plan.tick, Hold.LEASE_STALE, "held instead: paused after the decision")
        try:
            self._backend.apply(commands)
        except FairleadError as error:
            self._hold_instead(plan.tick, str(error))
        if self._trace is not None and before is not None:
            self._log.trace(plan.tick, self._trace.packed(), *before)

    def void(self, tick: int, hold: Hold, event: str) -> None:
        """Every part held in ``tick``, whatever had been decided; the log says so too."""
        with self._changed:
            self._core.void(hold)
            acted, lease_ns = self._core.acted, self._core.lease_ns
        self._log.tick(tick, self._clock(), acted, event, lease_ns)

    def _hold_instead(self, tick: int, reason: str) -> None:
        """The backend refused a command the gate had released: stop, and hold this tick."""
        self._stops.raise_stop(f"the backend refused a released command: {reason}")
        self.void(tick, Hold.STOPPED, f"held instead: {reason}")
        self._backend.apply({})
