"""A robot that measures wrongly, or does not do what it is told."""

from __future__ import annotations

import time
from functools import partial

from bench.equipment.live_robot import wait_for
from bench.faults.faulty_hal import CAMERA, GRIPPER, JOINT, OFFSET_RAD, PUSH_M
from bench.faults.faulty_stage import SEEING_AGE_TICKS, STOP_RAMP_MS, FaultyStage
from bench.faults.row import Row, Shot
from fairlead.messages import GateState

GRASP_TICKS = 25
LAYOUT_MS = 200.0
"""Faulty layouts of two ticks in a row end a goal."""


def stops(fault: str, codes: tuple[str, ...], robot: FaultyStage) -> Shot:
    """The gate stops by itself, under one of the codes, and the robot holds."""
    goal = robot.start_moving()
    before = dict(robot.client.gate_status().counters)
    injected_ns = robot.fault(fault)
    try:
        shot = robot.hold_shot(injected_ns)
        gate = robot.client.gate_status()
        assert gate.state in (GateState.STOPPED, GateState.LATCHED), gate
        raised = [code for code in codes if dict(gate.counters).get(code, 0) > before.get(code, 0)]
        assert raised, f"stopped for another reason: {gate.cause}"
        robot.ended(goal)
    finally:
        robot.fault("")
    return Shot(
        shot.measured_ms, injected_ns, shot.ended_ns, shot.tick_ms, f"{raised[0]}: {gate.cause}"
    )


def loses_object(robot: FaultyStage) -> Shot:
    """The fingers have stood still around something for half a second, then close."""
    goal = robot.start_moving()
    robot.fault("object")
    held_ns = time.monotonic_ns()
    wait_for(lambda: len(robot.motion.since(held_ns)) > GRASP_TICKS, "the grasp is seen")
    assert not goal.done(), goal.result()
    injected_ns = robot.fault("")
    shot = robot.hold_shot(injected_ns)
    gate = robot.client.gate_status()
    assert "G042" in gate.cause and GRIPPER in gate.cause, gate.cause
    robot.ended(goal)
    return Shot(shot.measured_ms, injected_ns, shot.ended_ns, shot.tick_ms, gate.cause)


def runs_on(robot: FaultyStage) -> Shot:
    """The HAL's log says that it holds, its robot turns on."""
    goal = robot.start_moving()
    robot.fault("runs on")
    injected_ns = time.monotonic_ns()
    try:
        robot.client.stop("test")
        latched: list[int] = []

        def is_latched() -> bool:
            latched[:] = [
                stamp
                for stamp, lease in list(robot.leases)
                if stamp >= injected_ns and lease.state == GateState.LATCHED
            ]
            return bool(latched)

        wait_for(is_latched, "the gate latches", 10.0)
    finally:
        robot.fault("")
    robot.ended(goal)
    cause = robot.client.gate_status().cause
    assert "G043" in cause, cause
    taken_ms = (latched[0] - injected_ns) / 1e6
    return Shot(taken_ms, injected_ns, latched[0], robot.tick_ms(injected_ns), cause)


def goal_fails(fault: str, kind: str, texts: tuple[str, ...], robot: FaultyStage) -> Shot:
    """The robot holds, and the goal's failure is of that kind and says these texts."""
    goal = robot.start_moving()
    injected_ns = robot.fault(fault)
    try:
        shot = robot.hold_shot(injected_ns)
        result = robot.ended(goal)
    finally:
        robot.fault("")
    assert (result.outcome, result.kind) == ("failed", kind), result
    missing = [text for text in texts if text not in result.detail]
    assert not missing, f"{result.detail!r} does not say {missing}"
    return Shot(shot.measured_ms, injected_ns, shot.ended_ns, shot.tick_ms, result.detail)


def blinded(fault: str, says: str) -> partial[Shot]:
    """The goal's failure names the camera and what it does."""
    return partial(goal_fails, fault, "camera_lost", (f"camera {CAMERA.name}", says))


BLIND_MS = 500.0
"""The skill's age_max_ticks, a tick to notice, the gate's word and a tick to hold, and spare."""
NAMES_CAMERA = f"hold; the error names the camera (age_max_ticks {SEEING_AGE_TICKS})"
NAMES_FRAME = "hold; the error names the frame"
KEEPS = "stop under the declared code"
ROWS = (
    Row(28, f"{JOINT} measured NaN", "stop", 100, "faulty", partial(stops, "nan", ("G011",))),
    Row(28, f"{JOINT} measured {OFFSET_RAD} rad off", "stop", 200, "faulty",
        partial(stops, "offset", ("G013", "G040"))),
    Row(28, "every joint frozen while told to move", "stop", 250, "faulty",
        partial(stops, "frozen", ("G041", "G040"))),
    Row(29, "transform stale", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(goal_fails, "frame stale", "layout_stale_frame", ("object",))),
    Row(29, "frame renamed", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(goal_fails, "frame renamed", "layout_stale_frame", ("object",))),
    Row(29, "loop in the tree of transforms", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(goal_fails, "frames in a loop", "layout_contested_frame", ("object", "goal"))),
    Row(30, "camera stalls", NAMES_CAMERA, BLIND_MS, "seeing",
        blinded("camera stalls", "nothing has come since")),
    Row(30, "camera repeats an exposure", NAMES_CAMERA, BLIND_MS, "seeing",
        blinded("camera repeats", "its last exposure came")),
    Row(30, "camera goes black", NAMES_CAMERA, BLIND_MS, "seeing",
        blinded("camera goes black", "pictures of one colour came since")),
    Row(36, "gripper loses what it holds", KEEPS, 200, "faulty", loses_object),
    Row(36, "contact", KEEPS, 200, "faulty", partial(stops, "contact", ("G042",))),
    Row(36, f"robot pushed by {PUSH_M} m a tick", KEEPS, 200, "faulty",
        partial(stops, "pushed", ("G040", "G013"))),
    Row(37, "HAL accepts the stop, the robot goes on", "the gate latches", STOP_RAMP_MS + 100.0,
        "faulty", runs_on, "stop to latch"),
)  # fmt: skip
