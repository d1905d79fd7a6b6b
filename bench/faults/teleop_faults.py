"""A person drives an arm with a leader arm, which is unplugged in mid-motion."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from bench.equipment.live_robot import wait_for
from bench.equipment.terminal import Terminal
from bench.faults.hardware_faults import unless_late
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.row import MachineLateError, Row, Shot
from bench.faults.servo_stage import SWING_RAD, ServoStage
from bench.faults.silent_gamepad import LIMITS, SPEED, TICK_S, last_motion_ns, moves, rests
from bench.so101_bus import calibration
from fairlead_tools.teleop.drive import RAMP_S
from fairlead_tools.teleop.follow import SILENCE_S

AGAIN = "holding, let the clutch in again"


@contextmanager
def _led(robot: ServoStage) -> Iterator[tuple[EmulatedArm, Terminal]]:
    """A leader far to one side, held there, and the command, clutch in: the arm follows slowly."""
    robot.make_ready(0)
    side = SWING_RAD if robot.measured[-1][1] < 0 else -SWING_RAD
    folder = robot.robot.scratch.state_dir / "leader"
    with emulated_arm(folder) as leader:
        calibration(folder / "leader.yaml", "leader")
        leader.order(f"pull 1 {side}")
        wait_for(lambda: abs(float(leader.order("where 1")) - side) < 0.05, "the leader is there")
        words = ["teleop", "--deployment", str(robot.robot.scratch.file), "--speed", str(SPEED)]
        words += ["--device", "so101", "--port", str(leader.port)]
        words += ["--calibration", str(folder / "leader.yaml")]
        command = [sys.executable, "-m", "fairlead_tools.cli.main", *words]
        person = Terminal(command, os.environ | {"TERM": "dumb"})
        try:
            _begins(robot, person)
            yield leader, person
        finally:
            person.end()


def _begins(robot: ServoStage, person: Terminal) -> None:
    try:
        person.wait_for("you drive arm, gripper")
        _lets_in(robot, person)
    except AssertionError as error:
        if robot.others_are_busy:
            raise MachineLateError(f"nobody began to drive: {error}") from error
        raise


def _lets_in(robot: ServoStage, person: Terminal) -> None:
    person.press(" ")
    began_ns = time.monotonic_ns()
    wait_for(lambda: moves(robot, began_ns), "the arm follows")


def leader_cable_out(robot: ServoStage) -> Shot:
    """From the loss of the leader's servos to the last tick that moved."""
    with _led(robot) as (leader, person):
        injected_ns = time.monotonic_ns()
        leader.order("unplug 1")
        wait_for(lambda: rests(robot, injected_ns), "it comes to rest")
        rested_ns = last_motion_ns(robot, injected_ns)
        person.wait_for(AGAIN)
        plugged_ns = time.monotonic_ns()
        leader.order("plug")
        wait_for(lambda: rests(robot, plugged_ns), "it stays at rest")
        assert not moves(robot, plugged_ns), "it moved before the clutch was let in"
        _lets_in(robot, person)
    every_row_was_judged_for_its_tick(robot)
    return _shot(robot, injected_ns, rested_ns)


def leader_adapter_out(robot: ServoStage) -> Shot:
    """From the loss of the port to the last tick that moved; the command ends."""
    with _led(robot) as (leader, person):
        injected_ns = time.monotonic_ns()
        leader.process.terminate()
        assert person.ended() == 1, person.output
        wait_for(lambda: "is gone: adapter unplugged?" in person.output, person.output)
        wait_for(lambda: rests(robot, injected_ns), "it comes to rest")
        assert not robot.client.gate_status().claims
    every_row_was_judged_for_its_tick(robot)
    return _shot(robot, injected_ns, last_motion_ns(robot, injected_ns))


def _shot(robot: ServoStage, injected_ns: int, rested_ns: int) -> Shot:
    rest_ms = (rested_ns - injected_ns) / 1e6
    return Shot(rest_ms, injected_ns, rested_ns, robot.tick_ms(injected_ns))


assert LIMITS.stop_lag_s is not None
REST_MS = 1e3 * (RAMP_S + LIMITS.stop_lag_s + 3 * TICK_S)
"""Ramp, the arm's lag; a tick each until it is noticed, judged, and measured."""
CABLE_MS, ADAPTER_MS = 1e3 * SILENCE_S + REST_MS, 100 + REST_MS
ROWS = (
    Row(48, "leader arm's cable comes off while it drives",
        "slows down, holds; moves again once the clutch is let in", CABLE_MS, "servos",
        partial(unless_late, leader_cable_out, CABLE_MS), "fault to rest"),
    Row(48, "leader arm's adapter unplugged while it drives",
        "slows down, holds; the command ends and says so", ADAPTER_MS, "servos",
        partial(unless_late, leader_adapter_out, ADAPTER_MS), "fault to rest"),
)  # fmt: skip
