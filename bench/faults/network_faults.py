"""A bad or dead network between the services and their router."""

from __future__ import annotations

import random
import signal
import threading
import time
from collections.abc import Callable
from functools import partial

from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import MotionLine
from bench.faults.live_stage import LATE_TICK_MS
from bench.faults.motion_rules import every_row_was_judged_for_its_tick, no_old_row_acts
from bench.faults.proxy import (
    Rule,
    delays,
    doubles,
    drop,
    forward,
    gap,
    loses,
    stalls,
    swaps,
)  # fmt: skip
from bench.faults.routed_stage import RoutedStage
from bench.faults.row import MachineLateError, Row, Shot
from fairlead.deploy.hosts import ROUTER
from fairlead.messages import GateState, Hold

BAD_S = 2.0
DARK_S = 0.13
"""More than two ticks: longer than a lease lives and a tick lasts, so one tick must hold."""
LEASE_LIFE_MS, LAPSE_MS = 75.0, 50.0
SEEN_NS = 500_000_000
STOP_MS = 300.0


def lost_state(robot: RoutedStage) -> Shot:
    """What the HAL says is lost; what it is told arrives."""
    goal = robot.start_moving()
    injected_ns = robot.proxies["hal"].set("up", drop)
    shot = robot.hold_shot(injected_ns)
    stop_ms = robot.stop_ms(injected_ns)
    robot.good_network()
    robot.ended(goal)
    gap_ms = robot.lease_gap_ms(injected_ns, injected_ns + int(stop_ms * 1e6))
    text = f"stopped after {stop_ms:.0f} ms, longest gap of leases {gap_ms:.0f} ms"
    if stop_ms > STOP_MS and gap_ms > LATE_TICK_MS:
        raise MachineLateError(text)
    assert stop_ms <= STOP_MS, text
    return Shot(shot.measured_ms, injected_ns, shot.ended_ns, shot.tick_ms,
                f"gate stopped after {stop_ms:.0f} ms")  # fmt: skip


def partition(service: str, robot: RoutedStage) -> Shot:
    """Both directions of one service's link are dead; the link itself stays open."""
    goal = robot.start_moving()
    shot = robot.hold_shot(robot.proxies[service].both(drop))
    robot.good_network()
    robot.finish(goal)
    every_row_was_judged_for_its_tick(robot)
    return shot


def bad_network(service: str, rule: Callable[[], Rule], may_hold: bool, robot: RoutedStage) -> Shot:
    """A link is bad for two seconds; rows act in their tick, once, or not at all."""
    goal = robot.start_moving()
    proxy = robot.proxies[service]
    tick_ms = robot.tick_ms(time.monotonic_ns())
    injected_ns = proxy.set("up", rule(), new_links=forward)
    proxy.set("down", rule(), new_links=forward)  # one of its own: some remember batches
    threading.Event().wait(BAD_S)
    ended_ns = proxy.both(forward)
    every_row_was_judged_for_its_tick(robot)
    lines = [line for line in robot.motion.since(injected_ns) if line.stamp_ns < ended_ns]
    held = sum(not line.moves for line in lines)
    if not may_hold:
        robot.none_held(lines)
    robot.good_network()
    robot.finish(goal)
    first = next((line.stamp_ns for line in lines if not line.moves), None)
    note = f"{held} of {len(lines)} ticks held"
    if first is None:
        return Shot(None, injected_ns, ended_ns, tick_ms, note)
    return Shot((first - injected_ns) / 1e6, injected_ns, ended_ns, tick_ms, note)


def dark_leases(rule: Callable[[float], Rule], robot: RoutedStage) -> Shot:
    """Leases and rows of two ticks do not come, or come late: what held stays held.

    The time is from where the newest lease lapsed, by the HAL's own log of when it came.
    """
    goal = robot.start_moving()
    tick_ms = robot.tick_ms(time.monotonic_ns())
    injected_ns = robot.proxies["hal"].set("down", rule(DARK_S))
    wait_for(lambda: bool(robot.motion.since(injected_ns + SEEN_NS)), "the HAL hears leases again")
    robot.proxies["hal"].set("down", forward)
    lines = robot.motion.since(injected_ns)
    ended_ns = lines[-1].stamp_ns
    every_row_was_judged_for_its_tick(robot)  # also: no verdict resumes after a hold
    robot.finish(goal)
    held = _first([line for line in lines if not line.moves], "held")
    stale = _first([line for line in lines if set(line.holds) == {Hold.LEASE_STALE}], "stale")
    lapsed_ms = (stale.stamp_ns - stale.lease_ns) / 1e6 - LEASE_LIFE_MS
    held_ms = (held.stamp_ns - injected_ns) / 1e6
    before = {v for line in lines if line.stamp_ns < held.stamp_ns for v in line.verdicts}
    after = {v for line in lines if line.stamp_ns > held.stamp_ns for v in line.verdicts}
    assert not before & after, "rows from before the hold acted after it"
    note = f"went on under {len(after)} new verdicts"
    return Shot(lapsed_ms, injected_ns, ended_ns, tick_ms, note, also=held_ms)


def _first(lines: list[MotionLine], what: str) -> MotionLine:
    assert lines, f"no tick was {what}"
    return lines[0]


def kill_router(robot: RoutedStage) -> Shot:
    goal = robot.start_moving()
    shot = robot.hold_shot(robot.signal(ROUTER, signal.SIGKILL))
    robot.router_restarted()
    robot.finish(goal)
    assert GateState(robot.client.gate_status().state) != GateState.BOOT
    return shot


def pause_router(robot: RoutedStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = robot.signal(ROUTER, signal.SIGSTOP)
    shot = robot.hold_shot(injected_ns)
    woken_ns = robot.signal(ROUTER, signal.SIGCONT)
    robot.good_network()
    robot.finish(goal)
    every_row_was_judged_for_its_tick(robot)
    no_old_row_acts(robot, woken_ns)
    return shot


RNG = random.Random(15)
BAD = (
    ("safety", "1 % of messages lost", lambda: loses(0.01, RNG), False, None),
    ("hal", "1 % of messages lost", lambda: loses(0.01, RNG), False, None),
    ("safety", "10 % of messages lost", lambda: loses(0.1, RNG), True, None),
    ("safety", "30 % of messages lost", lambda: loses(0.3, RNG), True, None),
    ("safety", "delay 200 +- 100 ms", lambda: delays(0.2, 0.1, RNG), True, 200),
    ("safety", "each second message overtakes one", swaps, True, None),
    ("safety", "each message twice", lambda: doubles, False, None),
)
WHOSE = {"safety": "gate's", "hal": "HAL's"}
ROWS = (
    Row(10, "router killed, restarted", "hold; all reconnect by themselves", 150, "routed",
        kill_router),
    Row(11, "router paused, TCP alive", "hold", 150, "routed", pause_router),
    Row(12, "partition between runner and gate", "hold", 550, "routed",
        partial(partition, "runner")),
    Row(13, "partition between gate and HAL", "hold", 150, "routed", partial(partition, "hal")),
    Row(14, "one-way loss of the HAL's state", "hold; gate stops within 300 ms", 150,
        "routed", lost_state),
    *(
        Row(15, f"{WHOSE[service]} link for {BAD_S:g} s: {what}",
            "each row in its tick, once, or hold" if may_hold else "no effect", bound, "routed",
            partial(bad_network, service, rule, may_hold), "first hold", 5)
        for service, what, rule, may_hold, bound in BAD
    ),
    *(
        Row(42, f"leases and rows of {DARK_S * 1e3:g} ms {what} in mid-chunk",
            "hold until a new verdict", LAPSE_MS, "routed",
            partial(dark_leases, rule), "lapse to hold",
            also="fault to hold")
        for what, rule in (("come late", stalls), ("are lost", gap))
    ),
)  # fmt: skip
