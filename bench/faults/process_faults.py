"""Services that are killed, paused, or left without processor time in mid-motion."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from dataclasses import replace
from itertools import pairwise

import pytest

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage
from bench.faults.motion_rules import every_row_was_judged_for_its_tick, no_old_row_acts
from bench.faults.row import Row, Shot
from fairlead.errors import ServiceError
from fairlead.messages import GateState
from fairlead.operate.goal_hearing import Progress

GATE_SLEEP_S = 5.0
AFTER_TICKS = 20
BUSY_LOOPS, BUSY_S = 4, 2.0
STOPPED = (GateState.STOPPED, GateState.LATCHED)  # the third stop within a minute latches


def kill_gate(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    shot = robot.hold_shot(robot.signal("safety", signal.SIGKILL))
    assert robot.ended(goal).outcome == "failed"
    robot.restarted("safety")
    robot.client.wait_gate_follows()
    gate = robot.client.gate_status()
    assert GateState(gate.state) is GateState.LATCHED and gate.latch_id != 0
    return shot


def pause_gate(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.signal("safety", signal.SIGSTOP)
    shot = robot.hold_shot(injected_ns)
    threading.Event().wait(GATE_SLEEP_S)
    woken_ns = robot.signal("safety", signal.SIGCONT)
    robot.ended(goal)
    no_old_row_acts(robot, woken_ns)
    return shot


def busy_machine(robot: LiveStage) -> Shot:
    """Rows act in their own tick or not at all, and never after a gap that hid a lost lease."""
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(4)]
    try:
        threading.Event().wait(BUSY_S)
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    ended_ns = time.monotonic_ns()
    every_row_was_judged_for_its_tick(robot)
    lines = robot.motion.since(injected_ns)
    gaps = [(b.stamp_ns - a.stamp_ns) / 1e6 for a, b in pairwise(lines) if b.moves]
    held = sum(not line.moves for line in lines)
    robot.finish(goal)
    note = f"{held} of {len(lines)} ticks held"
    return Shot(max(gaps, default=0.0), injected_ns, ended_ns, robot.tick_ms(injected_ns), note)


def kill_runner(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    shot = robot.hold_shot(robot.signal("runner", signal.SIGKILL))
    wait_for(lambda: not robot.client.gate_status().claims, "the gate ends its claim")
    with pytest.raises(ServiceError, match="runner went away"):
        robot.ended(goal)
    robot.restarted("runner")
    return shot


def pause_runner(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    shot = robot.hold_shot(robot.signal("runner", signal.SIGSTOP))
    wait_for(lambda: not robot.client.gate_status().claims, "the gate ends its claim")
    robot.signal("runner", signal.SIGCONT)
    assert robot.ended(goal).kind == "claim_lost"
    return shot


def kill_hal(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    old, injected_ns = robot.client.hal_status().session, robot.signal("hal", signal.SIGKILL)
    stop_ms = robot.stop_ms(injected_ns)
    result = robot.ended(goal)
    assert result.outcome == "failed" and result.kind
    robot.restarted("hal")
    robot.client.wait_gate_follows()
    new = robot.client.hal_status().session
    assert new != old and robot.client.gate_status().state != GateState.ARMED
    assert not any(line.moves for line in robot.motion.read() if line.session == new)
    ended_ns = injected_ns + int(stop_ms * 1e6)
    return Shot(stop_ms, injected_ns, ended_ns, robot.tick_ms(injected_ns))


def pause_hal(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.signal("hal", signal.SIGSTOP)
    stop_ms = robot.stop_ms(injected_ns)
    woken_ns = robot.signal("hal", signal.SIGCONT)
    assert robot.ended(goal).outcome == "failed"
    lines = robot.motion_ended(woken_ns)
    # The period that was interrupted may still be written down; no later one may move.
    assert not any(line.moves for line in lines[1:])
    every_row_was_judged_for_its_tick(robot)
    ended_ns = injected_ns + int(stop_ms * 1e6)
    return Shot(stop_ms, injected_ns, ended_ns, robot.tick_ms(injected_ns))


def kill_assembler(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.signal("state_assembler", signal.SIGKILL)
    shot = goal_without_layouts(robot, goal, injected_ns)
    robot.restarted("state_assembler")
    no_row_acts_again(robot, shot)
    return shot


def pause_assembler(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.signal("state_assembler", signal.SIGSTOP)
    shot = goal_without_layouts(robot, goal, injected_ns)
    robot.signal("state_assembler", signal.SIGCONT)
    no_row_acts_again(robot, shot)
    return shot


def goal_without_layouts(robot: LiveStage, goal: Future[Progress], injected_ns: int) -> Shot:
    """To the goal's typed end; `also`: to the hold."""
    result = robot.ended(goal)
    failed_ms = (time.monotonic_ns() - injected_ns) / 1e6
    assert (result.outcome, result.kind) == ("failed", "layout_missing"), result
    hold = robot.hold_shot(injected_ns)
    return replace(hold, measured_ms=failed_ms, also=hold.measured_ms)


def no_row_acts_again(robot: LiveStage, shot: Shot) -> None:
    """What was ended stays ended when layouts come again."""
    here_ns = time.monotonic_ns()
    robot.motion_ended(here_ns, settle_ticks=AFTER_TICKS)
    assert not any(line.moves for line in robot.motion.since(shot.ended_ns)), "it moved again"


GOAL_ENDED = "goal's end"
HOLD = "fault to hold"
TO_STOP = "stop"
ROWS = (
    Row(1, "gate killed", "hold; the gate starts latched", 150, "robot", kill_gate),
    Row(2, "gate paused 5 s", "hold; on wake no old row acts", 150, "robot", pause_gate),
    Row(
        3, f"{BUSY_LOOPS} busy loops for {BUSY_S:g} s",
        "each row in its tick, or hold", 150, "robot", busy_machine,
        "gap", excused=False,
    ),
    Row(
        4, "runner killed in mid-chunk", "its rows end with its heartbeats", 550, "robot",
        kill_runner,
    ),
    Row(
        5, "runner paused", "its rows end with its heartbeats; old chunks are refused",
        550, "robot", pause_runner,
    ),
    Row(
        7, "HAL killed, restarted", "stop; the new session is not armed",
        300, "robot", kill_hal, TO_STOP,
    ),
    Row(
        8, "HAL paused", "stop; on wake expired rows are discarded",
        300, "robot", pause_hal, TO_STOP,
    ),
    Row(
        9, "state_assembler killed", "hold; the error names the layout",
        1000, "robot", kill_assembler, GOAL_ENDED, also=HOLD,
    ),
    Row(
        9, "state_assembler paused", "hold; the goal fails; on wake nothing moves again",
        1000, "robot", pause_assembler, GOAL_ENDED, also=HOLD,
    ),
)  # fmt: skip
