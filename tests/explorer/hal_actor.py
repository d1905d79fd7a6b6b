"""The HAL in virtual time: the real core and a kinematic robot, in the host's rhythm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fairlead.hal.backend import Measurement
from fairlead.hal.core import HalCore, Pacing, TickPlan
from fairlead.hal.identity import identity_of
from fairlead.messages import (
    Acted,
    FloatArray,
    HalStatus,
    JointState,
    Lease,
    SafeChunk,
    StopLevel,
    encode,
    pack_floats,
)
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend
from tests.explorer.channel import MS, Schedule

BASE = 2
PERIOD_NS = 50 * MS
REPEAT_NS = 100 * MS
STOP_REPEAT_NS = 50 * MS
STATUS_NS = 500 * MS
OWN_STOPS = 1 << 62
"""Ids of stops that it raises itself begin above."""


@dataclass(frozen=True)
class Tick:
    """What the robot did in one tick, and where it was before."""

    tick: int
    time_ns: int
    positions: FloatArray
    acted: Acted
    command: FloatArray | None


class HalActor:
    """Publishes states, takes leases and chunks, steps the robot; keeps its history."""

    def __init__(
        self,
        robot: RobotManifest,
        pacing: Pacing,
        session: int,
        schedule: Schedule,
        publish: Callable[[str, bytes], None],
    ) -> None:
        self._backend = KinematicBackend(robot)
        self._found = self._backend.describe()
        self._identity = identity_of(robot, "sim", "explored")
        self._pacing: Pacing = pacing
        self._session = session
        self._schedule = schedule
        self._publish = publish
        self.core = HalCore(session, pacing, len(robot.parts), robot.n_dof, robot.tick_period_ns)
        self.history: list[Tick] = []
        self.refused: list[str] = []
        self.leases: list[tuple[int, Lease]] = []
        self.stops: list[tuple[int, StopLevel]] = []
        self.tick = 1
        self._before: Measurement | None = None
        self._own_stops = OWN_STOPS
        self._state = b""
        self._sent_ns = 0

    def start(self) -> None:
        self._send_status()
        self._repeat_stops()
        if self._pacing == "realtime":
            self._period()
        else:
            self._measure()
            self._watch()

    def on_lease(self, lease: Lease) -> None:
        self.leases.append((self._schedule.now_ns, lease))
        self._note(self.core.on_lease(lease, self._schedule.now_ns))

    def on_safe_chunk(self, chunk: SafeChunk) -> None:
        self._note(self.core.on_safe_chunk(chunk))

    def on_stop(self, stop: StopLevel) -> None:
        self.stops.append((self.tick, stop))
        self._note(self.core.on_stop(stop))

    def _note(self, refused: str) -> None:
        if refused:
            self.refused.append(refused)
        if self._pacing == "lockstep":
            self._advance()

    def _measure(self) -> None:
        measured = self._backend.read()
        self._state = encode(
            JointState(
                session=self._session,
                tick=self.tick,
                episode_tick=1,
                stamp_ns=self._schedule.now_ns,
                positions=pack_floats(measured.positions),
                velocities=pack_floats(measured.velocities),
                efforts=pack_floats(measured.efforts),
                acted=self.core.acted,
                robot_hash=self._identity.robot_hash,
            )
        )
        self._send_state()

    def _send_state(self) -> None:
        self._sent_ns = self._schedule.now_ns
        self._publish("joint_state", self._state)

    def _try_tick(self) -> bool:
        measured = self._backend.read()
        is_still = self._identity.is_still(measured, self._before)
        plan = self.core.decide(self.tick, self._schedule.now_ns, is_still)
        if not isinstance(plan, TickPlan):
            return False
        command = plan.commands.get(BASE)
        self.history.append(
            Tick(
                tick=self.tick,
                time_ns=self._schedule.now_ns,
                positions=np.array(measured.positions),
                acted=plan.acted[BASE],
                command=None if command is None else command.values,
            )
        )
        self._before = measured
        names = self._identity.parts
        self._backend.apply({names[part]: value for part, value in plan.commands.items()})
        self.tick += 1
        return True

    def _advance(self) -> None:
        while self._try_tick():
            self._measure()

    def _watch(self) -> None:
        """Lockstep: step what needs no message; repeat a tick that is 100 ms old."""
        self._advance()
        if self._schedule.now_ns - self._sent_ns >= REPEAT_NS:
            self._send_state()
        self._schedule.at(self._schedule.now_ns + 10 * MS, self._watch)

    def _period(self) -> None:
        self._measure()
        assert self._try_tick(), "realtime never waits"
        self._schedule.at(self._schedule.now_ns + PERIOD_NS, self._period)

    def _repeat_stops(self) -> None:
        for cause, detail in self.core.demanded_stops:
            self._own_stops += 1
            stop = StopLevel(stop_id=self._own_stops, by="hal", reason=f"{cause}: {detail}")
            self.stops.append((self.tick, stop))
            self.core.on_stop_raised(cause, stop)
        for stop in self.core.stops_to_repeat():
            self._publish("stop_level", encode(stop))
        self._schedule.at(self._schedule.now_ns + STOP_REPEAT_NS, self._repeat_stops)

    def _send_status(self) -> None:
        identity, found = self._identity, self._found
        status = HalStatus(
            session=self._session,
            robot="explored",
            robot_hash=identity.robot_hash,
            pacing=self._pacing,
            period_ns=identity.period_ns,
            tick=self.tick,
            episode_tick=1,
            state="ready",
            detail="",
            joints=identity.joints,
            passive_joints=identity.passive_joints,
            parts=found.parts,
            simulator_order=found.simulator_order,
            cameras=(),
            has_task=False,
            overruns=0,
        )
        self._publish("hal_status", encode(status))
        self._schedule.at(self._schedule.now_ns + STATUS_NS, self._send_status)
