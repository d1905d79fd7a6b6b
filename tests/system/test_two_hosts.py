"""The policy on another host: the same numbers, and a hold when the network dies.

Two network namespaces with a veth link are the hosts. Where the machine permits none, two
loopback addresses are: the numbers are still compared, the tests that cut the link skip.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.live_robot import MOVING_TICKS, wait_for
from bench.equipment.motion_log import (
    MotionLine,
    assert_held_within,
    hold_delay_ms,
)
from bench.faults.timer_process import TimerProcess
from fairlead.operate.goal_run import GoalOptions
from fairlead.paths import repo_root
from fairlead_skill_runner.trace import read_trace
from fairlead_tools.parity.deployed_episode import deployed_episodes, read_episode
from fairlead_tools.parity.episode_trace import compare
from tests.system.two_hosts import RUN, SKILL, TwoHosts, two_hosts
from tests.system.two_networks import TwoNetworks, two_networks

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

ONE_HOST = repo_root() / "compose" / "panda_mobile_sim.yaml"
SEED = 3
FAR = "0 1.2 0"
CUT_BOUND_MS = 550.0
ROUTER_BOUND_MS = 150.0
SETTLE_TICKS = 4
ROBOTS = [("robot", service) for service in ("router", "hal", "safety", "state_assembler")]


@pytest.fixture
def network() -> Iterator[TwoNetworks]:
    with two_networks() as network:
        yield network


@pytest.fixture(scope="module")
def timer() -> Iterator[TimerProcess]:
    with TimerProcess() as timer:
        yield timer


@pytest.fixture
def realtime(network: TwoNetworks, tmp_path: Path) -> Iterator[TwoHosts]:
    """New hosts and a whole link for each test: whatever the one before left, or how it failed."""
    with two_hosts(network, tmp_path / "realtime", "realtime") as hosts:
        yield hosts


@pytest.mark.thorough
def test_the_demo_across_two_hosts_packs_the_same_actions_as_on_one(
    network: TwoNetworks, tmp_path: Path
) -> None:
    print(f"hosts: {network.why_loopback or 'two network namespaces'} {network.addresses}")
    (one,) = deployed_episodes(
        ONE_HOST, GoalOptions(SKILL, deadline_ticks=1200), [SEED], tmp_path / "one", lambda _: None
    )
    with two_hosts(network, tmp_path / "two", "lockstep") as hosts:
        assert f"fairlead run {SKILL}" == RUN
        result = hosts.ask("gpu", "run", SKILL, "--seed", str(SEED))["result"]
        for host in ("gpu", "robot"):
            status = hosts.ask(host, "status")
            assert (status["access"], status["warnings"]) == ("closed", [])
            assert status["alive"] == [
                "hal", "runner", "safety", "state_assembler",
            ]  # fmt: skip
        for host, service in (*ROBOTS, ("gpu", "runner")):
            assert link_threads(hosts.pid(host, service)) == {"rx"}, service
        for host in ("gpu", "robot"):
            hosts.end(host)
    hal, runner = hosts.state_of("robot", "hal"), hosts.state_of("gpu", "runner")
    ticks = range(first_tick_of_the_episode(hal), result["last_tick"])
    calls = list(read_trace(runner / "trace.jsonl"))
    two = read_episode(hal, calls, ticks, result["outcome"] == "succeeded")
    assert one.trace.succeeded and two.succeeded
    rows = {row.quantity: row for row in compare(two, one.trace)}
    assert {name: row.difference for name, row in rows.items()} == dict.fromkeys(rows, "")
    assert rows["packed"].deployed > 100


def link_threads(pid: int) -> set[str]:
    """Kinds of Zenoh's threads that read or write links: TLS is not sound in both at once."""
    tasks = Path(f"/proc/{pid}/task").iterdir()
    names = {(task / "comm").read_text(encoding="ascii").partition("-")[0] for task in tasks}
    return names & {"rx", "tx"}


def first_tick_of_the_episode(hal: Path) -> int:
    """The tick of the newest reset, from the HAL's log."""
    lines = map(json.loads, (hal / "motion.jsonl").read_text(encoding="ascii").splitlines())
    resets = [line["tick"] for line in lines if line["event"] == f"reset_episode seed {SEED}"]
    return int(resets[-1])


def start_moving(hosts: TwoHosts) -> subprocess.Popen[str]:
    """A goal that an operator at the robot follows, and whose rows are being executed now."""
    acknowledge(hosts)
    began_ns = time.monotonic_ns()
    goal = hosts.start("robot", "run", "go-to", "--prompt", FAR, "--json")
    wait_for(lambda: moves_since(hosts, began_ns) or goal.poll() is not None, "it moves")
    assert goal.poll() is None, "\n".join(goal.communicate())
    return goal


def moves_since(hosts: TwoHosts, stamp_ns: int) -> bool:
    """Whether rows were executed in each of the newest ticks."""
    newest = hosts.motion.since(stamp_ns)[-MOVING_TICKS:]
    return len(newest) == MOVING_TICKS and all(line.moves for line in newest)


def held_since(hosts: TwoHosts, injected_ns: int) -> list[MotionLine]:
    """Every tick decided after an injection, once some held ticks have followed."""

    def held() -> bool:
        newest = hosts.motion.since(injected_ns)[-SETTLE_TICKS:]
        return len(newest) == SETTLE_TICKS and not any(line.moves for line in newest)

    wait_for(held, "the robot holds")
    return hosts.motion.since(injected_ns)


def check_bound(
    hosts: TwoHosts, timer: TimerProcess, injected_ns: int, bound_ms: float, what: str
) -> None:
    delay_ms = hold_delay_ms(held_since(hosts, injected_ns), injected_ns)
    late_ms = max(timer.late_ms(injected_ns, injected_ns + int(1e6 * delay_ms)))
    assert_held_within(bound_ms, hosts.motion.lines, injected_ns, late_ms, what)


def ended_badly(goal: subprocess.Popen[str], text: str) -> None:
    """The operator's command says why there is no result, or that the goal failed."""
    out, err = goal.communicate(timeout=60.0)
    assert goal.returncode != 0 and text in out + err, out + err


def acknowledge(hosts: TwoHosts) -> None:
    """Reset whatever the gate holds, as `fairlead status` lists it."""
    gate = hosts.ask("robot", "status")["gate"]
    for one in (gate["latch_id"], *gate["stop_ids"]):
        if one != "none":
            hosts.tell("robot", "reset", one)


def new_goal_moves(hosts: TwoHosts) -> None:
    """In realtime no more can be asked of a busy machine; whole goals are run in lockstep."""
    moving = start_moving(hosts)
    moving.send_signal(signal.SIGINT)
    ended_badly(moving, "cancelled")


def test_a_cut_link_ends_motion_and_once_healed_a_new_goal_moves_the_robot(
    realtime: TwoHosts, timer: TimerProcess
) -> None:
    if realtime.network.why_loopback:
        pytest.skip(f"the link cannot be cut: {realtime.network.why_loopback}")
    goal = start_moving(realtime)
    seen = len(realtime.printed("gpu"))
    injected_ns = realtime.network.cut()
    check_bound(realtime, timer, injected_ns, CUT_BOUND_MS, "link cut")
    ended_badly(goal, "runner went away")
    realtime.wait_printed("gpu", "lost the router", seen)
    healed_ns = realtime.network.heal()
    realtime.wait_printed("gpu", "is back", seen)
    assert not any(line.moves for line in realtime.motion.since(injected_ns)[20:])
    acknowledge(realtime)
    assert not any(line.moves for line in realtime.motion.since(healed_ns))
    new_goal_moves(realtime)


@pytest.mark.thorough
def test_a_killed_router_ends_motion_and_once_restarted_a_new_goal_moves_the_robot(
    realtime: TwoHosts, timer: TimerProcess
) -> None:
    pid, seen = realtime.pid("robot", "router"), len(realtime.printed("robot"))
    goal = start_moving(realtime)  # ends by itself: nothing that takes long comes from here on
    injected_ns = time.monotonic_ns()
    os.kill(pid, signal.SIGKILL)
    check_bound(realtime, timer, injected_ns, ROUTER_BOUND_MS, "router kill -9")
    realtime.wait_printed("robot", "router is ready again", seen)
    ended_badly(goal, "")
    wait_for(lambda: realtime.printed("robot")[seen:].count("is back") >= 2, "both reconnect")
    new_goal_moves(realtime)
