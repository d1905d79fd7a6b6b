"""Real processes are killed and stopped in mid-motion; the HAL's own log is the judge.

Every bound runs from the injection (CLOCK_MONOTONIC) to the first tick in which every
part held. The longest undisturbed tick of the same run is printed beside it.
"""

from __future__ import annotations

import os
import signal
from concurrent.futures import Future

import pytest

from fairlead.errors import ServiceError
from fairlead.messages import GateState, GoalResult
from fairlead.operate.goal_watch import Progress
from tests.system.live_robot import LiveRobot, wait_for
from tests.system.motion_log import assert_held_within

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(600)]

INJECTIONS = int(os.environ.get("FAIRLEAD_INJECTIONS", "2"))
GATE_BOUND_MS = 150.0
RUNNER_BOUND_MS = 550.0


def end_of(goal: Future[Progress]) -> GoalResult:
    result = goal.result(timeout=60.0).result
    assert result is not None
    return result


def every_row_was_judged_for_its_tick(robot: LiveRobot) -> None:
    """Over the whole log: no row late, none twice, none resumed after a hold.

    Row k of a released chunk may act only in its first tick plus k; and a part that held
    moves again only by a verdict that had not acted before the hold.
    """
    newest: dict[int, int] = {}
    spent: dict[tuple[int, int], set[int]] = {}  # (session, part): verdicts ended by a hold
    acting: dict[tuple[int, int], set[int]] = {}
    checked = 0
    for line in robot.motion.read():
        assert line.tick > newest.get(line.session, 0)
        newest[line.session] = line.tick
        for index, (hold, (verdict, row)) in enumerate(zip(line.holds, line.rows, strict=True)):
            part = (line.session, index)
            if hold:
                spent.setdefault(part, set()).update(acting.pop(part, set()))
                continue
            assert verdict not in spent.get(part, set()), f"{verdict:x} resumed after a hold"
            acting.setdefault(part, set()).add(verdict)
            if verdict in robot.first_ticks:  # a watcher may miss a message, too
                assert line.tick == robot.first_ticks[verdict] + row
                checked += 1
    assert checked > 0


def check_bound(robot: LiveRobot, injected_ns: int, bound_ms: float, what: str) -> None:
    before = [line for line in robot.motion.read() if line.stamp_ns < injected_ns][-10:]
    after = robot.motion_ended(injected_ns)
    assert_held_within(bound_ms, after, before, injected_ns, what)


def moves_again(robot: LiveRobot) -> None:
    """After the operator's reset and a new arm, a new goal moves the robot."""
    goal = robot.start_moving()
    robot.client.disarm()
    assert end_of(goal).kind == "claim_lost"
    every_row_was_judged_for_its_tick(robot)


@pytest.mark.parametrize("run", range(INJECTIONS))
def test_a_killed_gate_ends_motion_and_boots_latched(realtime_robot: LiveRobot, run: int) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    injected_ns = robot.signal("safety", signal.SIGKILL)
    check_bound(robot, injected_ns, GATE_BOUND_MS, "gate kill -9")
    assert end_of(goal).outcome == "failed"
    robot.restarted("safety")
    robot.client.wait_gate_follows()
    gate = robot.client.gate_status()
    assert GateState(gate.state) is GateState.LATCHED and gate.latch_id != 0
    moves_again(robot)


@pytest.mark.parametrize("run", range(INJECTIONS))
def test_a_stopped_gate_ends_motion_and_its_old_rows_never_run(
    realtime_robot: LiveRobot, run: int
) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    injected_ns = robot.signal("safety", signal.SIGSTOP)
    check_bound(robot, injected_ns, GATE_BOUND_MS, "gate SIGSTOP")
    woken_ns = robot.signal("safety", signal.SIGCONT)
    end_of(goal)
    judged_before = {
        v for line in robot.motion.lines if line.stamp_ns < woken_ns for v in line.verdicts
    }
    for line in robot.motion.since(woken_ns):
        assert not line.verdicts & judged_before
    moves_again(robot)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("run", range(INJECTIONS))
def test_a_lost_runner_ends_motion(
    realtime_robot: LiveRobot, number: signal.Signals, run: int
) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    injected_ns = robot.signal("runner", number)
    check_bound(robot, injected_ns, RUNNER_BOUND_MS, f"runner {number.name}")
    wait_for(lambda: not robot.client.gate_status().claims, "the gate ends its claim")
    if number is signal.SIGKILL:
        with pytest.raises(ServiceError, match="the runner went away"):
            end_of(goal)
        robot.restarted("runner")
    else:
        robot.signal("runner", signal.SIGCONT)
        assert end_of(goal).kind == "claim_lost"
    moves_again(robot)


def test_a_killed_hal_ends_its_session_and_nothing_old_runs_in_the_next(
    realtime_robot: LiveRobot,
) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    old = robot.client.hal_status().session
    robot.signal("hal", signal.SIGKILL)
    result = end_of(goal)
    assert result.outcome == "failed" and result.kind
    robot.restarted("hal")
    robot.client.wait_gate_follows()
    new = robot.client.hal_status().session
    assert new != old
    assert robot.client.gate_status().state != GateState.ARMED
    newer = [line for line in robot.motion.read() if line.session == new]
    assert not any(line.moves for line in newer)
    moves_again(robot)


def test_a_stopped_hal_runs_no_expired_row_when_it_wakes(realtime_robot: LiveRobot) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    robot.signal("hal", signal.SIGSTOP)
    # The third stop within a minute latches, so both are right here.
    wait_for(
        lambda: robot.client.gate_status().state in (GateState.STOPPED, GateState.LATCHED),
        "the gate stops for want of a state",
    )
    woken_ns = robot.signal("hal", signal.SIGCONT)
    assert end_of(goal).outcome == "failed"
    lines = robot.motion_ended(woken_ns)
    # The period that was interrupted may still be written down; no later one may move.
    assert not any(line.moves for line in lines[1:])
    moves_again(robot)


def test_a_killed_assembler_starves_the_goal_which_fails_by_name(
    realtime_robot: LiveRobot,
) -> None:
    robot = realtime_robot
    goal = robot.start_moving()
    injected_ns = robot.signal("state_assembler", signal.SIGKILL)
    check_bound(robot, injected_ns, 1000.0, "state_assembler kill -9")
    result = end_of(goal)
    assert (result.outcome, result.kind) == ("failed", "stalled")
    assert "layout" in result.detail
    robot.restarted("state_assembler")
    moves_again(robot)
