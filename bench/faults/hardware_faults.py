"""Servos and their bus, and the processor of the arm's host; a gamepad."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

from bench.equipment.motion_log import MotionLine
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.process_faults import BUSY_LOOPS, BUSY_S, busy_machine
from bench.faults.row import MachineLateError, Row, Shot
from bench.faults.servo_stage import ServoStage
from bench.faults.silent_gamepad import SILENT_MS, silent_gamepad
from bench.so101_bus import ROBOT
from fairlead_hal_so101.options import ServoLimits

TICK_MS = ROBOT.tick_period_ns / 1e6
NOISY_S = 2.0
CUT, BLOCKED = 5, 2
NAMES = dict(enumerate(ROBOT.joint_names, start=1))


def cable_out(robot: ServoStage) -> Shot:
    """A servo, and those behind it, are silent: reads are lost until that is a fault."""
    goal = robot.start_moving()
    injected_ns = robot.order(f"unplug {CUT}")
    silent = ", ".join(f"{one} ({name})" for one, name in NAMES.items() if one >= CUT)
    shot = robot.fault_shot(injected_ns, f"servo {silent} does not answer")
    assert robot.ended(goal).outcome == "failed"
    robot.repair()
    return shot


def adapter_out(robot: ServoStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.unplug()
    shot = robot.fault_shot(injected_ns, "is gone: adapter unplugged?")
    assert robot.ended(goal).outcome == "failed"
    robot.plug_in()
    return shot


def noise(share: float, most_held: int | None, robot: ServoStage) -> Shot:
    """Each row in its tick, once. A tick is held where an answer and its repetition are lost.

    most_held: so many ticks at most, and no fault; None: where too many reads in a row are lost, a
        fault that names servos.
    """
    goal = robot.start_moving()
    before = int(robot.arm.order("wrong"))
    injected_ns = robot.order(f"noise {share}")
    threading.Event().wait(NOISY_S)
    ended_ns = robot.order("noise 0")
    every_row_was_judged_for_its_tick(robot)
    lines = [line for line in robot.motion.since(injected_ns) if line.stamp_ns <= ended_ns]
    held = sum(not line.moves for line in lines)
    wrong = int(robot.arm.order("wrong")) - before
    note = f"{wrong} answers with a wrong byte, {held} of {len(lines)} ticks held"
    hal = robot.client.hal_status()
    if most_held is not None:
        if hal.state == "fault" and robot.others_are_busy:  # it had no time to hear the answers
            raise MachineLateError(hal.detail)
        assert wrong, "no answer had a wrong byte"
        assert hal.state != "fault" and held <= most_held, f"{note}; {hal.detail}"
    if hal.state == "fault":
        assert "measurements lost in a row: servo " in hal.detail, hal.detail
        note = f"{note}; {hal.detail}"
        assert robot.ended(goal).outcome == "failed"
        robot.repair()
    else:
        robot.finish(goal)
    gap_ms = longest_gap_ms(lines, ended_ns)
    return Shot(gap_ms, injected_ns, ended_ns, robot.tick_ms(injected_ns), note)


def unless_late(inject: Callable[[ServoStage], Shot], bound_ms: float, robot: ServoStage) -> Shot:
    """A miss counts, unless others were busy and the HAL's ticks came so late."""
    shot = inject(robot)
    over_ms = (shot.measured_ms or 0.0) - bound_ms
    if over_ms <= 0.0:
        return shot
    lines = [line for line in robot.motion.since(shot.began_ns) if line.stamp_ns <= shot.ended_ns]
    took_ms = (lines[-1].stamp_ns - lines[0].stamp_ns) / 1e6 if lines else 0.0
    late_ms = took_ms - TICK_MS * (len(lines) - 1)
    if over_ms <= late_ms and robot.others_are_busy:
        raise MachineLateError(f"{over_ms:.0f} ms over the bound, ticks {late_ms:.0f} ms late")
    return shot


def longest_gap_ms(lines: Sequence[MotionLine], ended_ns: int) -> float:
    """Before a tick that moved, up to a time."""
    gaps = [later.stamp_ns - one.stamp_ns for one, later in pairwise(lines)
            if later.moves and later.stamp_ns <= ended_ns]  # fmt: skip
    return max(gaps, default=0) / 1e6


def overloaded(robot: ServoStage) -> Shot:
    """A servo has been blocked for too long: it says so, and pushes with a fifth of its torque."""
    goal = robot.start_moving()
    injected_ns = robot.order(f"overload {BLOCKED}")
    shot = robot.hold_shot(injected_ns)
    result = robot.ended(goal)
    said = f"servo {BLOCKED} ({NAMES[BLOCKED]}): says overload"
    assert result.outcome == "failed" and said in result.detail, result
    robot.repair()
    return Shot(shot.measured_ms, injected_ns, shot.ended_ns, shot.tick_ms, result.detail)


CABLE_MS = 300.0
"""lost_ticks and one more, of up to 33 ms each; then each silent servo is asked twice."""
ADAPTER_MS = 100.0
"""A tick, a read and another of one servo, and what the emulator takes to end."""
OVERLOAD_MS = (ServoLimits().ticks + 3) * TICK_MS
GAP, GAP_MS = "gap", 150.0
STOP = "gate's stop"
ROWS = (
    Row(43, f"cable to servo {CUT} and those behind it comes off",
        "HAL's fault names them, gate stops", CABLE_MS, "servos",
        partial(unless_late, cable_out, CABLE_MS), also=STOP),
    Row(43, "adapter of the servos' bus unplugged", "HAL's fault says so, gate stops", ADAPTER_MS,
        "servos", partial(unless_late, adapter_out, ADAPTER_MS), also=STOP),
    Row(44, "1 % of servos' answers have a wrong byte", "at most 6 of 100 ticks held", GAP_MS,
        "servos", partial(noise, 0.01, 6), GAP),
    Row(44, "10 % of servos' answers have a wrong byte",
        "each row in its tick, once, or a fault that names servos", GAP_MS, "servos",
        partial(noise, 0.1, None), GAP),
    Row(45, f"servo {BLOCKED} says overload in motion", "stop, naming it", OVERLOAD_MS, "servos",
        partial(unless_late, overloaded, OVERLOAD_MS)),
    Row(46, "gamepad silent while deflected", "slows down, holds; moves again when it speaks",
        SILENT_MS, "servos", silent_gamepad, "last event to rest"),
    Row(47, f"{BUSY_LOOPS} busy loops for {BUSY_S:g} s beside a HAL of 50 Hz",
        "each row in its tick, or hold", GAP_MS, "servos", busy_machine, GAP, excused=False),
)  # fmt: skip
