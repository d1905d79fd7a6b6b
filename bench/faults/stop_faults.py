"""An operator's stop, on a good day and on bad ones."""

from __future__ import annotations

import secrets
import subprocess
import sys
import threading
import time

from bench.faults.live_stage import LiveStage
from bench.faults.proxy import forward, keeps_every
from bench.faults.routed_stage import OPERATOR, RoutedStage
from bench.faults.row import Row, Shot
from fairlead.deploy.deployment import load_deployment
from fairlead.messages import GateState, StopLevel
from fairlead.operate.client import RobotClient
from fairlead.operate.protective_stop import REPEAT_S
from fairlead.wire.bus import Qos

STOP_MS = 70.0  # 20 ms and one tick
LOSSY_MS = 500.0
LOST_OF = 10


def operator_stop(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    stop_id = robot.client.stop("test")
    shot = robot.hold_shot(injected_ns)
    assert stop_id in robot.client.gate_status().stop_ids
    robot.ended(goal)
    return shot


def lossy_stop(robot: RoutedStage) -> Shot:
    """The operator's messages pass a link that loses nine of ten, the first nine first."""
    proxy = robot.proxies[OPERATOR]
    with RobotClient(load_deployment(robot.operators_file)) as operator:
        operator.wait_alive("safety", timeout_s=30.0)
        publisher = operator.bus.publisher(operator.keys.stop, StopLevel, Qos.HOT)
        goal = robot.start_moving()
        message = StopLevel(stop_id=secrets.randbits(63) + 1, by="operator", reason="test")
        injected_ns, sent = proxy.set("up", keeps_every(LOST_OF)), 0
        while not any(message.stop_id in lease.stop_ids for _, lease in robot.leases[-100:]):
            publisher.put(message)
            sent += 1
            assert sent < 100, "no lease lists the stop"
            next_s = injected_ns / 1e9 + sent * REPEAT_S  # its own lateness does not add up
            threading.Event().wait(max(0.0, next_s - time.monotonic()))
        proxy.set("up", forward)
        shot = robot.hold_shot(injected_ns, f"{sent} sent")
        assert sent > LOST_OF // 2, "the link lost too little"
        robot.ended(goal)
        return shot


def stop_in_a_flood(robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    file = str(robot.robot.scratch.file)
    words = [sys.executable, "-m", "bench.faults.flood", file, "candidates"]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as flood:
        try:
            assert flood.stdout is not None and flood.stdout.readline() == b"ready\n"
            before, began = refused_so_far(robot), time.monotonic()
            threading.Event().wait(0.5)
            rate = (refused_so_far(robot) - before) / (time.monotonic() - began)
            moved = robot.motion.read()[-1].moves
            injected_ns = time.monotonic_ns()
            robot.client.stop("test")
            note = f"{rate:.0f} chunks a second refused; moving before: {moved}"
            assert rate > 0, "nothing of the flood arrives"
            assert moved or goal.done(), note
            shot = robot.hold_shot(injected_ns, note)
        finally:
            flood.kill()
    robot.ended(goal)
    assert robot.client.gate_status().state in (GateState.STOPPED, GateState.LATCHED)
    return shot


def refused_so_far(robot: LiveStage) -> int:
    """Chunks refused for their session or robot."""
    return dict(robot.client.gate_status().counters).get("G002", 0)


FROM_PUT = "stop to hold"
ROWS = (
    Row(26, "operator stop in motion", "stops", STOP_MS, "robot", operator_stop, FROM_PUT),
    Row(26, "operator stop, 9 of 10 of its messages lost", "stops", LOSSY_MS, "routed",
        lossy_stop, FROM_PUT),
    Row(26, "operator stop while 10,000 chunks a second flood in", "stops", STOP_MS, "open",
        stop_in_a_flood, FROM_PUT),
)  # fmt: skip
