"""A backend that fails: the robot holds, the gate is told, and the process stays to say why."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from fairlead.errors import ConfigError, HardwareError
from fairlead.hal.backend import NotCarriedOutError
from fairlead.hal.host import HalHost
from fairlead.hal.identity import HostSettings
from fairlead.hal.lease_follower import OTHER_LIMITS
from fairlead.hal.plan_executor import MotionLog
from fairlead.messages import (
    Hold,
    Lease,
    StopLevel,
)
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.memory_bus import MemoryBus
from tests.hal.gate_messages import SESSION, lease
from tests.hal.running_host import (
    KEYS,
    NO_STOP,
    FailingBackend,
    RunningHost,
    identity,
    move_until,
    wait_until,
)


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


def test_a_measurement_of_too_few_joints_is_told_by_its_size(running: RunningHost) -> None:
    count = len(running.backend.read().efforts)
    running.backend.leaves_out = 1
    wait_until(lambda: running.status().state == "fault")
    said = (
        f"read(): expected efforts as an array of {count} joints, commanded ones first, got shape "
    )
    assert running.stops[0].reason == f"backend fault: {said}[{count - 1}]"


def test_a_computer_that_was_suspended_in_mid_motion_does_not_go_on(running: RunningHost) -> None:
    move_until(running, lambda: running.backend.applied[-1:] == [1])
    running.suspended_ns += 3600 * 10**9
    wait_until(lambda: bool(running.stops))
    assert running.stops[0].reason == "the computer was suspended"
    stopped = running.stops[0].stop_id
    wait_until(lambda: running.backend.applied[-3:] == [0] * 3)
    assert {stop.stop_id for stop in running.stops} == {stopped}


def test_hardware_that_fails_a_command_is_a_fault_not_a_refused_value(running: RunningHost) -> None:
    running.backend.apply_error = HardwareError("gripper: no answer")
    move_until(running, lambda: running.status().state == "fault")
    assert running.stops[0].reason == "backend fault: gripper: no answer"


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
    assert "session 0000000000001b59, is not of the gate that sent" in running.status().detail
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


def test_a_backend_with_another_joint_order_is_refused_with_both_lists(tmp_path: Path) -> None:
    other = replace(identity(), joints=("left", "right"))
    log = MotionLog(tmp_path, SESSION, trace=False)
    settings = HostSettings("hal", KEYS, "realtime", SESSION)
    with pytest.raises(ConfigError, match=r"expected joints \['left', 'right'\], got \['base_x'"):
        HalHost(settings, other, FailingBackend(), MemoryBus(), log, suspended=int)
    log.close()


def test_a_gate_with_other_limits_is_named_until_one_with_the_same_is_heard(tmp_path: Path) -> None:
    host = RunningHost(tmp_path, limits=bytes([1]) * 32)
    leases = host.bus.publisher(KEYS.lease, Lease, Qos.HOT)
    leases.put(msgspec.structs.replace(lease(1, 1), config_hash=bytes([2]) * 32))
    wait_until(lambda: host.status().state == "holding")
    assert host.status().detail == OTHER_LIMITS
    leases.put(msgspec.structs.replace(lease(2, 1), config_hash=bytes([1]) * 32))
    wait_until(lambda: host.status().state == "ready")
    host.close()


def test_a_row_that_was_not_told_is_held_without_a_stop_or_a_fault(running: RunningHost) -> None:
    running.backend.apply_error = NotCarriedOutError("a packet was lost")
    seen = len(running.motion_path.read_text().splitlines())
    move_until(running, lambda: "a packet was lost" in running.motion_path.read_text())
    assert len(running.motion_path.read_text().splitlines()) > seen
    assert running.status().state == "ready"
    assert running.stops == []


def test_a_hold_that_is_not_told_after_a_refused_row_is_no_fault(running: RunningHost) -> None:
    running.backend.refuses_commands = True
    running.backend.hold_error = NotCarriedOutError("a packet was lost")
    move_until(running, lambda: bool(running.stops))
    wait_until(lambda: running.status().state == "holding")
    tick = running.status().tick
    running.backend.hold_error = None
    wait_until(lambda: running.status().tick > tick)
