"""Beginnings, ends and long runs: power cycles, start orders, memory."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import wait
from contextlib import contextmanager
from itertools import permutations
from pathlib import Path

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import LiveRobot, wait_for
from bench.faults.frame_faults import resident_kb
from bench.faults.live_stage import SKILL, SOURCE, Changes, LiveStage, live_stage
from bench.faults.row import Row, Shot
from fairlead.deploy.registry import Registry
from fairlead.messages import GateState
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead_tools.supervisor.command_line import service_command, service_environment
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

SERVICES = ("hal", "safety", "state_assembler", "runner")
ORDERS = list(permutations(SERVICES))
SOAK_TICKS = 100_000
SOAK_VARIABLE = "FAIRLEAD_SOAK_TICKS"
WARM_TICKS = 5_000
GOAL_TICKS = 5_000
GROWTH_PERCENT = 2.0
IN_USE = "in use by another process"


def power_cycle(robot: LiveStage) -> Shot:
    """Everything dies at once, and starts again."""
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    for service in SERVICES:
        robot.signal(service, signal.SIGKILL)
    wait([goal], timeout=60.0)
    robot.restarted(*SERVICES)
    gate = robot.client.wait_gate_follows(60.0)
    assert GateState(gate.state) is GateState.LATCHED, gate
    session = robot.client.hal_status().session
    assert not any(line.moves for line in robot.motion.read() if line.session == session)
    robot.finish(robot.start_moving())
    return Shot(None, injected_ns, time.monotonic_ns(), note="latched, held; moved after the reset")


class OrderStage:
    """Starts the services in each order, in turn."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._next = folder, 0

    def next_order(self) -> tuple[tuple[str, ...], Path]:
        """An order, spread over all of them, and a folder."""
        number, self._next = self._next, self._next + 1
        return ORDERS[number * 7 % len(ORDERS)], self._folder / str(number)


@contextmanager
def order_stage(folder: Path) -> Iterator[OrderStage]:
    """Nothing runs yet."""
    yield OrderStage(folder)


def start_order(stage: OrderStage) -> Shot:
    order, folder = stage.next_order()
    began_ns = time.monotonic_ns()
    options = ScratchOptions(pacing="lockstep", hal=LIGHT_HAL)
    scratch = make_scratch(SOURCE, folder, options)
    with scratch_robot(scratch, Registry(folder / "registry"), list(order)) as robot:
        live = LiveRobot(robot)
        goal = live.start_moving()
        live.client.disarm()
        result = goal.result(timeout=30.0).result
        assert result is not None and result.kind == "claim_lost", result
    return Shot(None, began_ns, time.monotonic_ns(), note=" ".join(order))


def idle_restarts(robot: LiveStage) -> Shot:
    """Each service dies while nothing moves; the next goal moves."""
    robot.recover()
    began_ns = time.monotonic_ns()
    for service in SERVICES:
        robot.signal(service, signal.SIGKILL)
        robot.restarted(service)
        robot.client.wait_gate_follows(60.0)
    robot.finish(robot.start_moving())
    return Shot(None, began_ns, time.monotonic_ns(), note="the next goal moved")


def second_of_a_kind(robot: LiveStage) -> Shot:
    """A second HAL and a second gate of the same robot: each ends and names the other."""
    began_ns, said = time.monotonic_ns(), []
    scratch = robot.robot.scratch
    for service in ("hal", "safety"):
        state = scratch.state_dir / f"second-{service}"
        words = service_command(scratch.file, scratch.deployment, service, state)
        done = subprocess.run(
            words,
            env=service_environment(),
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        last = (done.stdout + done.stderr).strip().splitlines()[-1]
        assert done.returncode != 0 and IN_USE in last and "fairlead ps" in last, last
        said.append(last)
    robot.finish(robot.start_moving())
    return Shot(None, began_ns, time.monotonic_ns(), note=" | ".join(said))


@contextmanager
def soak_stage(folder: Path) -> Iterator[LiveStage]:
    """The light robot in lockstep."""
    with live_stage(folder, Changes(pacing="lockstep")) as robot:
        yield robot


def soak(robot: LiveStage) -> Shot:
    """Goal after goal; what each process holds afterwards beside what it held when warm."""
    wanted = int(os.environ.get(SOAK_VARIABLE, SOAK_TICKS))
    robot.ready_to_move()
    began_ns, first = time.monotonic_ns(), robot.client.hal_status().tick
    warm: dict[str, int] = {}
    warm_tick, tick = 0, first
    while tick - first < wanted + WARM_TICKS:
        result = run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=GOAL_TICKS)).result
        assert result is not None and result.outcome == "deadline", result
        tick = robot.client.hal_status().tick
        if not warm and tick - first >= WARM_TICKS:
            warm, warm_tick = memory(robot), tick
    ended_ns, ticks = time.monotonic_ns(), tick - warm_tick
    grown = {name: 100 * (kb / warm[name] - 1) for name, kb in memory(robot).items()}
    rate = (tick - first) / ((ended_ns - began_ns) / 1e9)
    shares = ", ".join(f"{name} {percent:+.2f} %" for name, percent in grown.items())
    note = f"{ticks} ticks after warm-up at {rate:.0f} a second: {shares}"
    allowed = GROWTH_PERCENT * max(1.0, ticks / SOAK_TICKS)
    assert max(grown.values()) <= allowed, note
    robot.client.disarm()
    wait_for(lambda: not robot.client.gate_status().claims, "the claim ends")
    return Shot(None, began_ns, ended_ns, note=note)


def memory(robot: LiveStage) -> dict[str, int]:
    """Resident memory of each service [KiB]."""
    return {name: resident_kb(robot.supervisor.pid(name)) for name in SERVICES}


ROWS = (
    Row(39, "every service killed at once, started again", "hold; the gate starts latched", None,
        "robot", power_cycle),
    Row(40, f"{SOAK_TICKS} ticks of goals in lockstep",
        f"no process grows by more than {GROWTH_PERCENT:g} % per {SOAK_TICKS} ticks", None, "soak",
        soak, injections=1),
    Row(41, f"services started in any order ({len(ORDERS)} there are)", "a goal moves the robot",
        None, "orders", start_order, injections=len(ORDERS)),
    Row(41, "each service killed while idle", "the next goal moves the robot", None, "robot",
        idle_restarts, injections=2),
    Row(41, "a second HAL, a second gate while one runs", "each ends and names the socket", None,
        "robot", second_of_a_kind, injections=2),
)  # fmt: skip
