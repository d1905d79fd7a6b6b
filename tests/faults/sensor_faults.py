"""A robot that measures wrongly, or does not do what it is told."""

from __future__ import annotations

from functools import partial

from fairlead.messages import GateState
from tests.faults.faulty_hal import JOINT
from tests.faults.faulty_stage import FaultyStage
from tests.faults.row import Row, Shot

LAYOUT_MS = 350.0
"""Four faulty layouts in a row end a goal: that is 200 ms at 20 Hz before anything happens."""


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


def layout_lost(fault: str, kind: str, texts: tuple[str, ...], robot: FaultyStage) -> Shot:
    """The robot holds, and the goal's failure names the frame."""
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


NAMES_FRAME = "hold; the goal's failure names the frame"
ROWS = (
    Row(28, f"{JOINT} measured NaN", "stop", 100, "faulty", partial(stops, "nan", ("G011",))),
    Row(29, "transform stale", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(layout_lost, "frame stale", "layout_stale_frame", ("object",))),
    Row(29, "frame renamed", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(layout_lost, "frame renamed", "layout_stale_frame", ("object",))),
    Row(29, "loop in the tree of transforms", NAMES_FRAME, LAYOUT_MS, "faulty",
        partial(layout_lost, "frames in a loop", "layout_loop", ("object", "goal"))),
)  # fmt: skip
