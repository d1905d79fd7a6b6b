"""A HAL host in a thread, with a backend that a test breaks, and a gate that lets it move."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from bench.equipment.live_robot import wait_for
from fairlead.deploy.service_manager import Pulse
from fairlead.errors import ConfigError
from fairlead.hal.backend import Measurement, PartCommand
from fairlead.hal.core import Pacing
from fairlead.hal.host import HalHost
from fairlead.hal.identity import HalIdentity, HostSettings, identity_of
from fairlead.hal.plan_executor import MotionLog
from fairlead.keys import Keys
from fairlead.messages import (
    Acted,
    HalStatus,
    JointState,
    Lease,
    SafeChunk,
    StatusQuery,
    StopLevel,
    decode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.memory_bus import MemoryBus
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend
from tests.hal.gate_messages import SESSION, chunk, grant, lease

KEYS = Keys("tested")
NO_STOP = b"stop!"


class FailingBackend(KinematicBackend):
    """Does what it is told until a test breaks it."""

    def __init__(self) -> None:
        self.refuses_resets = False
        super().__init__(load_robot("panda_mobile"))
        self.read_error: Exception | None = None
        self.leaves_out = 0
        self.refuses_commands = False
        self.refusal = "driver: expected 7 joints, got 6"
        self.apply_error: Exception | None = None
        self.hold_error: Exception | None = None
        self.applied: list[int] = []

    def read(self) -> Measurement:
        if self.read_error is not None:
            raise self.read_error
        whole = super().read()
        return replace(whole, efforts=whole.efforts[self.leaves_out :])

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        if self.apply_error is not None and commands:
            raise self.apply_error
        if self.hold_error is not None and not commands:
            raise self.hold_error
        if commands and self.refuses_commands:
            raise ConfigError(self.refusal)
        self.applied.append(len(commands))
        super().apply(commands)

    def reset(self, seed: int) -> None:
        if self.refuses_resets:
            raise ConfigError("hardware has no episodes")
        super().reset(seed)


class PausingLog(MotionLog):
    """Called between a decision and its act: where a test stops the process."""

    def __init__(self, folder: Path, at_tick: Callable[[Sequence[Acted]], None]) -> None:
        super().__init__(folder, SESSION, trace=False)
        self._at_tick = at_tick

    def tick(
        self, tick: int, stamp_ns: int, acted: Sequence[Acted], event: str | None, lease_ns: int
    ) -> None:
        super().tick(tick, stamp_ns, acted, event, lease_ns)
        self._at_tick(acted)


class RunningHost:
    """A host in a thread, on a bus in memory."""

    def __init__(self, folder: Path, pacing: Pacing = "realtime", limits: bytes = b"") -> None:
        self.paused_ns = self.suspended_ns = 0
        self.frame_id = ""  # a test's that has the arm moved in a frame of its choice
        self.backend = FailingBackend()
        self.pulse = Pulse()
        self.bus = MemoryBus()
        self.stops: list[StopLevel] = []
        self.bus.subscribe(KEYS.stop, self._on_stop)
        self.states: list[JointState] = []
        self.bus.subscribe(KEYS.joints, lambda s: self.states.append(decode(JointState, s.payload)))
        self.motion_path = folder / "motion.jsonl"
        self.host = HalHost(
            HostSettings("hal", KEYS, pacing, SESSION),
            replace(identity(), limits=limits),
            self.backend,
            self.bus,
            PausingLog(folder, self._pause_at),
            clock=lambda: time.monotonic_ns() + self.paused_ns,
            suspended=lambda: self.suspended_ns,
            pulse=self.pulse,
        )
        self.pauses_at_rows = False
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self.host.run, args=(self._stopping,))
        self._thread.start()

    def status(self) -> HalStatus:
        return decode(HalStatus, self.bus.query(KEYS.hal_status, StatusQuery(), 1.0))

    def _pause_at(self, acted: Sequence[Acted]) -> None:
        if self.pauses_at_rows and not self.paused_ns and not acted[3].hold:
            self.paused_ns = 5 * 10**9

    def _on_stop(self, sample: Sample) -> None:
        if sample.payload != NO_STOP:
            self.stops.append(decode(StopLevel, sample.payload))

    def close(self) -> None:
        self._stopping.set()
        self._thread.join(timeout=10)
        assert not self._thread.is_alive()


def identity() -> HalIdentity:
    """Of which it does not say what limits it has: the leases here are of no gate file."""
    return replace(identity_of(load_robot("panda_mobile"), "sim", "tested"), limits=b"")


def wait_until(condition: Callable[[], bool]) -> None:
    wait_for(condition, "what the host's thread does", 20.0)


def move_until(running: RunningHost, condition: Callable[[], bool]) -> None:
    """Release and grant rows, as a gate would, until there is something to see."""
    wait_until(lambda: running.status().tick > 2)
    seq = 0
    while not condition():
        seq, ticks = seq + 1, len(running.states)
        assert seq < 500, "nothing happened in 500 rounds"
        publish(running, seq, running.status().tick)
        wait_until(lambda: condition() or len(running.states) > ticks)  # noqa: B023


def publish(running: RunningHost, seq: int, tick: int) -> None:
    """A lease and a chunk for the ticks just ahead (part 3 is the composite switch)."""
    rows = chunk(seq, first_tick=tick + 2, horizon=4, parts=(3,))
    if running.frame_id:
        told = {"part": 0, "mode": ControlMode.CARTESIAN_DELTA, "frame_id": running.frame_id}
        values = pack_floats(np.zeros((4, 6)))
        arm = msgspec.structs.replace(rows.parts[0], **told, values=values)
        rows = msgspec.structs.replace(rows, parts=(arm,))
    running.bus.publisher(KEYS.safe("runner"), SafeChunk, Qos.HOT).put(rows)
    message = lease(seq, tick, [grant(tick + 10)])
    running.bus.publisher(KEYS.lease, Lease, Qos.HOT).put(message)
