"""The HAL host: the tick loop every HAL shares, around a backend and the execution guard.

Each tick: measure, publish (joints last), decide, log, act. Realtime ticks come at the
control rate; a lockstep world waits for its decision and repeats the tick every 100 ms.
The loop runs in the caller's thread; the transport's threads only fill the core.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from fairlead.deploy.service_manager import Pulse
from fairlead.errors import FairleadError
from fairlead.hal.backend import Backend, CameraFeed, Measurement, TraceSource
from fairlead.hal.core import HalCore, TickPlan, Wait
from fairlead.hal.episode_reset import EpisodeResetHandler
from fairlead.hal.identity import HalIdentity, HostSettings
from fairlead.hal.inbox import HalInbox, SharedCore
from fairlead.hal.lease_follower import OTHER_LIMITS
from fairlead.hal.loop_state import Episode, PeriodClock
from fairlead.hal.plan_executor import FaultHold, MotionLog, PlanExecutor
from fairlead.hal.status_and_stops import (
    STOP_REPEAT_NS,
    HalState,
    StatusPublisher,
    StopPublisher,
    names_of,
)
from fairlead.hal.tick_publisher import FrameSource, TickPublisher
from fairlead.messages import GateState, Hold, ResetEpisode
from fairlead.reason_text import reason_of, short_text
from fairlead.wire.bus import Bus

_LOG = logging.getLogger("hal.host")

REPEAT_NS = 100_000_000
"""Lockstep: a waiting or paused world publishes its tick again this often."""
SUSPENDED_NS = 10_000_000
"""More than clocks that are read one after the other differ by."""


class HalHost:
    """Runs one backend behind the HAL contract until told to stop.

    Args:
        identity: the robot by its manifest; must agree with what the backend found.
        log: where decisions are recorded.
        feed: renders camera frames elsewhere; None for no cameras.
        trace: shows the simulator's state, for a log that records traces.
        clock: monotonic nanoseconds.
        suspended: nanoseconds that no clock above counted.
        pulse: beats in each tick and wait; while the backend resets, it rests.

    Attributes:
        resets: takes requests for a new episode.

    Raises:
        ConfigError: if the backend's joints or parts differ from the manifest's.
    """

    def __init__(
        self,
        settings: HostSettings,
        identity: HalIdentity,
        backend: Backend,
        bus: Bus,
        log: MotionLog,
        feed: CameraFeed | None = None,
        trace: TraceSource | None = None,
        clock: Callable[[], int] = time.monotonic_ns,
        *,
        suspended: Callable[[], int],
        pulse: Pulse | None = None,
    ) -> None:
        found = backend.describe()
        identity.check(found)
        self._settings = settings
        self._identity = identity
        self._backend = backend
        self._log = log
        self._clock = clock
        self._pulse = pulse or Pulse()
        self._suspended, self._suspended_ns = suspended, suspended()
        self._tick = 1
        self._fault = ""
        self._fault_hold = FaultHold(backend)
        self._event: str | None = None
        self._measured: Measurement | None = None
        self._before: Measurement | None = None  # a tick before, in the same episode
        self._stands = False
        self._episode = Episode()
        self._period = PeriodClock(identity.period_ns, clock())
        sizes = len(identity.parts), len(identity.joints), identity.period_ns
        self._core = SharedCore(HalCore(settings.session, settings.pacing, *sizes, identity.limits))
        self._ticks = TickPublisher(bus, settings, found.cameras)
        self._frames = FrameSource(found.cameras, feed, self._ticks, settings)
        self._stops = StopPublisher(bus, settings, self._core)
        self._status = StatusPublisher(bus, settings, identity, found)
        shown = trace if log.traces else None
        self._executor = PlanExecutor(
            backend, settings, identity, self._core, self._stops, log, shown, clock
        )
        self.resets = EpisodeResetHandler(self._core, settings.service)
        self._inbox = HalInbox(self._core, bus, settings.keys, clock, self._ticks.is_own)

    def run(self, stopping: threading.Event) -> None:
        """Tick until ``stopping`` is set; after a backend fault, hold and say so until then."""
        try:
            self._ticks.set_static(self._tick, self._backend.static_transforms())
            self._period.restart(self._clock())
            while not stopping.is_set():
                self._run_tick(stopping)
        except Exception as error:  # noqa: BLE001 - a driver may raise anything; the robot holds
            self._enter_fault(error)
        while not stopping.wait(self._identity.period_ns * 1e-9):
            self._fault_hold.command()
            self._fault_hold.beside(self._housekeep)
        self._close()

    def _run_tick(self, stopping: threading.Event) -> None:
        if not self._settings.lockstep and self._wait_for_period(stopping):
            return
        self._stop_after_suspension()
        self._measure_and_publish()
        self._finish_reset_if_still()
        plan = self._await_plan(stopping)
        if plan is not None:
            self._executor.carry_out(plan)
            self._episode.stepped()
            self._tick += 1

    def _stop_after_suspension(self) -> None:
        """To leases, heartbeats and deadlines it was no time, so motion would just go on."""
        before, self._suspended_ns = self._suspended_ns, self._suspended()
        if self._suspended_ns - before > SUSPENDED_NS:
            self._stops.raise_stop("the computer was suspended")

    def _wait_for_period(self, stopping: threading.Event) -> bool:
        """Realtime: wait until the tick is due. True if told to stop meanwhile."""
        overruns = self._period.overruns
        wait_ns = self._period.start_tick(self._clock())
        if self._period.overruns > overruns:
            self._event = "overrun"
        return stopping.wait(wait_ns * 1e-9) if wait_ns > 0 else stopping.is_set()

    def _measure_and_publish(self) -> None:
        begins = self._tick == self._episode.first_tick
        self._before, self._measured = (
            None if begins else self._measured,
            self._identity.measure(self._backend),
        )
        now_ns = self._clock()
        self._ticks.begin(self._tick, self._backend.transforms(), now_ns)
        self._frames.send_due(self._tick, self._episode.first_tick, self._backend.snapshot)
        self._ticks.finish(
            self._tick,
            self._episode.first_tick,
            now_ns,
            self._measured,
            self._core.read(lambda core: core.acted),
            self._identity.robot_hash,
            self._backend.task(),
        )
        self._stands = self._identity.is_still(self._measured, self._before)

    def _await_plan(self, stopping: threading.Event) -> TickPlan | None:
        """The plan for this tick; None if told to stop. Realtime has one at once."""
        repeat_ns = self._clock() + REPEAT_NS
        while not stopping.is_set():
            self._housekeep()
            self._go_on_with_reset()
            wait_ns = min(repeat_ns - self._clock(), STOP_REPEAT_NS)
            decided = self._core.decide(self._decide, max(0, wait_ns) * 1e-9)
            if isinstance(decided, TickPlan):
                self._event = None
                return decided
            if self._clock() >= repeat_ns:
                self._ticks.repeat(self._clock())
                repeat_ns = self._clock() + REPEAT_NS
        return None

    def _decide(self, core: HalCore) -> TickPlan | Wait:
        now_ns = self._clock()
        if self._settings.lockstep and self._episode.announced_ns is not None:
            return Wait("standstill")  # the old episode takes no further step
        decided = core.decide(self._tick, now_ns, self._is_still())
        if isinstance(decided, TickPlan):
            self._executor.record(decided, now_ns, self._event)
        return decided

    def _go_on_with_reset(self) -> None:
        """Announce a reset that is due; carry it out once the gate can no longer be armed."""
        if self._episode.resetting is None:
            self.resets.answer_finished(self._clock())
            request = self._core.change(self._announce_reset)
            if request is not None:
                self._housekeep()  # the gate refuses to arm while the status says resetting
                self._episode.announce(request, self._clock())
        elif self._episode.announced_ns is not None:
            self._reset_if_disarmed(self._episode.resetting, self._episode.announced_ns)

    def _announce_reset(self, core: HalCore) -> ResetEpisode | None:
        """In one step: between the look at the gate and the hold nothing is decided."""
        request = self.resets.due(core)
        if request is not None:
            core.set_resetting(True)
            self._episode.announce(request, self._clock())
        return request

    def _reset_if_disarmed(self, request: ResetEpisode, announced_ns: int) -> None:
        now_ns = self._clock()
        try:
            if not self._core.read(lambda core: self.resets.may_begin(core, announced_ns, now_ns)):
                return
            self._pulse.rest()
            self._backend.reset(request.seed)
        except FairleadError as error:
            self._episode.abandon()
            self._core.change(lambda core: core.set_resetting(False))
            self._housekeep()  # the status first, as below
            self.resets.refuse(request, error)
            return
        self._episode.begin(self._tick)
        self._ticks.set_static(self._episode.first_tick, self._backend.static_transforms())
        self._period.restart(self._clock())
        self._event = f"reset_episode seed {request.seed}"
        _LOG.info("%s, by %s", self._event, request.by or "somebody")

    def _finish_reset_if_still(self) -> None:
        request = self._episode.resetting
        if request is not None and self._episode.comes_to_rest and self._is_still():
            if self._core.read(lambda core: core.gate_state) == GateState.ARMED:
                # It repeats what it has released: dropping that once would not do.
                self._stops.raise_stop("the gate was armed while the episode was reset")
            reply = self._episode.finish(self._tick)
            self._core.change(lambda core: core.set_resetting(False))
            self._housekeep()  # the status first: the gate refuses to arm while it says resetting
            self.resets.finish(request, reply, self._clock())

    def _is_still(self) -> bool:
        return not self._episode.must_step and self._stands

    def _measures_still(self) -> bool:
        before, self._measured = self._measured, self._identity.measure(self._backend)
        return self._identity.is_still(self._measured, before)

    def _housekeep(self) -> None:
        """Repeat stops and post the status; cheap, once per tick or wait."""
        self._pulse.beat()
        now_ns = self._clock()
        self._stops.raise_demanded()
        self._stops.repeat_due(now_ns)
        state, detail = self._state()
        self._status.post(
            now_ns,
            tick=self._tick,
            episode_tick=self._episode.first_tick,
            state=state,
            detail=detail,
            overruns=self._period.overruns,
            cameras=self._frames.working,
        )

    def _state(self) -> tuple[HalState, str]:
        if self._fault:
            return "fault", f"{self._fault} ({self._fault_hold.detail})"
        if self._episode.resetting is not None:
            return "resetting", f"seed {self._episode.resetting.seed}"
        held = self._core.read(lambda core: core.held_stops)
        if held:
            return "holding", names_of(held)
        if self._core.read(lambda core: core.leases.has_other_limits):
            return "holding", OTHER_LIMITS
        return "ready", short_text(self._frames.failure)

    def _enter_fault(self, error: Exception) -> None:
        """The backend cannot be trusted any more: no more ticks, and the gate is told.

        What it did in this tick is unknown; it is told to hold now and in every period.
        """
        self._fault_hold.command()
        self._fault = reason_of(error)
        if not isinstance(error, FairleadError):
            _LOG.error("backend failed", exc_info=error)
        said = f"backend fault: {self._fault}"
        self._fault_hold.beside(lambda: self._stops.raise_stop(said))
        self._fault_hold.beside(lambda: self._executor.void(self._tick, Hold.STOPPED, said))
        self._fault_hold.beside(lambda: self.resets.close(said))

    def _close(self) -> None:
        if not self._settings.lockstep:  # that world stands when nobody steps it
            self._fault_hold.brake(self._measures_still, self._identity.period_ns * 1e-9)
        self._inbox.close()
        self._status.close()
        self._frames.close()
        self._log.close()
        self._backend.close()
