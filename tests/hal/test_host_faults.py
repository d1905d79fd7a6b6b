"""A backend that fails: the robot holds, the gate is told, and the process stays to say why."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from bench.equipment.live_robot import wait_for
from fairlead.errors import ConfigError
from fairlead.hal.backend import Measurement, PartCommand
from fairlead.hal.host import HalHost
from fairlead.hal.identity import HalIdentity, HostSettings, identity_of
from fairlead.hal.plan_executor import MotionLog
from fairlead.keys import Keys
from fairlead.messages import (
    Acted,
    GateState,
    HalStatus,
    Hold,
    JointState,
    Lease,
    ResetEpisode,
    SafeChunk,
    StatusQuery,
    StopLevel,
    decode,
    encode,
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
        self.refuses_commands = False
        self.apply_error: Exception | None = None
        self.hold_error: Exception | None = None
        self.applied: list[int] = []

    def read(self) -> Measurement:
        if self.read_error is not None:
            raise self.read_error
        return super().read()

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        if self.apply_error is not None and commands:
            raise self.apply_error
        if self.hold_error is not None and not commands:
            raise self.hold_error
        if commands and self.refuses_commands:
            raise ConfigError("driver: expected 7 joints, got 6")
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
    """A realtime host in a thread, on a bus in memory."""

    def __init__(self, folder: Path) -> None:
        self.paused_ns = 0
        self.frame_id = ""  # a test's that has the arm moved in a frame of its choice
        self.backend = FailingBackend()
        self.bus = MemoryBus()
        self.stops: list[StopLevel] = []
        self.bus.subscribe(KEYS.stop, self._on_stop)
        self.states: list[JointState] = []
        self.bus.subscribe(KEYS.joints, lambda s: self.states.append(decode(JointState, s.payload)))
        self.motion_path = folder / "motion.jsonl"
        self.host = HalHost(
            HostSettings("hal", KEYS, "realtime", SESSION),
            identity(),
            self.backend,
            self.bus,
            PausingLog(folder, self._pause_at),
            clock=lambda: time.monotonic_ns() + self.paused_ns,
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
    return identity_of(load_robot("panda_mobile"), "sim", "tested")


def wait_until(condition: Callable[[], bool]) -> None:
    wait_for(condition, "what the host's thread does", 20.0)


@pytest.fixture
def running(tmp_path: Path) -> Iterator[RunningHost]:
    host = RunningHost(tmp_path)
    yield host
    host.close()


def test_a_read_that_fails_ends_the_ticks_stops_the_gate_and_is_said(running: RunningHost) -> None:
    wait_until(lambda: len(running.backend.applied) > 2)
    running.backend.read_error = OSError("bus off")
    wait_until(lambda: running.status().state == "fault")
    ended_at = running.status().tick
    wait_until(lambda: running.status().detail == "OSError: bus off (held)")
    assert running.stops[0].reason == "backend fault: OSError: bus off"
    wait_until(lambda: len(running.stops) >= 4)
    assert len({stop.stop_id for stop in running.stops}) == 1
    assert running.status().tick == ended_at


def test_after_a_driver_raised_in_mid_motion_the_hold_is_commanded_every_period(
    running: RunningHost,
) -> None:
    backend = running.backend
    backend.apply_error = OSError("CAN bus glitch")
    move_until(running, lambda: running.status().state == "fault")
    holds = len(backend.applied)
    wait_until(lambda: len(backend.applied) > holds + 3)
    assert set(backend.applied) == {0}
    assert running.status().detail == "OSError: CAN bus glitch (held)"
    last = json.loads(running.motion_path.read_text().splitlines()[-1])
    assert last["event"] == "backend fault: OSError: CAN bus glitch"
    assert (last["tick"], last["acted"][0][0]) == (running.status().tick, Hold.STOPPED)


def test_a_hold_that_the_driver_refuses_is_tried_again_and_the_status_says_so(
    running: RunningHost,
) -> None:
    backend = running.backend
    backend.hold_error = OSError("bus off")
    wait_until(lambda: "(the hold cannot be commanded)" in running.status().detail)
    backend.hold_error = None
    wait_until(lambda: running.status().detail == "OSError: bus off (held)")


def test_a_command_the_driver_refuses_is_held_instead_and_stops_the_gate(
    running: RunningHost,
) -> None:
    running.backend.refuses_commands = True
    move_until(running, lambda: bool(running.stops))
    assert "driver: expected 7 joints, got 6" in running.stops[0].reason
    assert set(running.backend.applied) == {0}
    wait_until(lambda: "held instead: driver" in running.motion_path.read_text())
    wait_until(lambda: running.status().state == "holding")


def test_a_released_command_that_does_not_fit_its_part_reaches_no_backend(
    running: RunningHost,
) -> None:
    running.frame_id = "odom"
    move_until(running, lambda: bool(running.stops))
    assert running.stops[0].reason == (
        "the backend refused a released command: hal: part arm: expected a frame of "
        "cartesian_delta, got 'odom' (valid: base_link)"
    )
    assert set(running.backend.applied) == {0}


def test_a_stop_that_cannot_be_read_or_listed_stops_under_an_id_of_the_hals_own(
    running: RunningHost,
) -> None:
    running.bus.deliver(Sample(KEYS.stop, NO_STOP))
    wait_until(lambda: running.status().state == "holding")
    assert "(unreadable stop: 5 bytes)" in running.status().detail
    running.bus.publisher(KEYS.stop, StopLevel, Qos.HOT).put(
        StopLevel(stop_id=0, by="operator", reason="now")
    )
    wait_until(lambda: "(stop without an id: by operator: now)" in running.status().detail)


def test_two_live_gates_stop_the_robot_and_the_status_names_them(running: RunningHost) -> None:
    leases = running.bus.publisher(KEYS.lease, Lease, Qos.HOT)
    left_at = time.monotonic()
    seq = 0
    while running.status().state != "holding":
        seq, ticks = seq + 1, len(running.states)
        leases.put(lease(seq, 1))
        leases.put(lease(seq, 1, epoch=lease(1, 1).epoch + 1))
        assert time.monotonic() < left_at + 20, "waited 20 s"
        wait_until(lambda: len(running.states) > ticks)  # noqa: B023
    assert time.monotonic() - left_at > 0.25
    assert "epoch 29, session 1b59, is not of the gate that sent" in running.status().detail
    wait_until(lambda: len(running.stops) > 1)  # repeated until a lease lists it
    assert len({stop.stop_id for stop in running.stops}) == 1


def test_a_row_decided_before_a_pause_is_not_carried_out_after_it(running: RunningHost) -> None:
    running.pauses_at_rows = True
    move_until(running, lambda: running.paused_ns > 0)
    said = "held instead: paused after the decision"
    wait_until(lambda: said in running.motion_path.read_text())
    lines = [json.loads(line) for line in running.motion_path.read_text().splitlines()]
    (held,) = (line for line in lines if line["event"] == said)
    assert {code for code, *_ in held["acted"]} == {Hold.LEASE_STALE}
    assert running.backend.applied[held["tick"] - 1] == 0


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


def test_a_reset_the_driver_does_not_know_is_refused_and_ticks_go_on(running: RunningHost) -> None:
    running.backend.refuses_resets = True
    disarmed = lease(1, 1, state=GateState.DISARMED)
    running.bus.publisher(KEYS.lease, Lease, Qos.HOT).put(disarmed)
    with pytest.raises(ConfigError, match="hardware has no episodes"):
        asyncio.run(running.host.resets.handle(encode(ResetEpisode(seed=1))))
    steps = len(running.backend.applied)
    wait_until(lambda: len(running.backend.applied) > steps + 2)
    assert running.states[-1].acted[0].hold != Hold.RESETTING


def test_a_backend_with_another_joint_order_is_refused_with_both_lists(tmp_path: Path) -> None:
    other = replace(identity(), joints=("left", "right"))
    log = MotionLog(tmp_path, SESSION, trace=False)
    settings = HostSettings("hal", KEYS, "realtime", SESSION)
    with pytest.raises(ConfigError, match=r"expected joints \['left', 'right'\], got \['base_x'"):
        HalHost(settings, other, FailingBackend(), MemoryBus(), log)
    log.close()
