"""Rows that are also done while the real simulator renders its cameras."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from bench.faults.camera_stage import CAMERAS, CameraStage
from bench.faults.live_stage import LiveStage
from bench.faults.process_faults import kill_gate, kill_runner
from bench.faults.row import MachineLateError, Row, Shot
from bench.faults.stop_faults import FROM_PUT, STOP_MS, operator_stop

BEFORE_NS = 600_000_000
RENDERING = f", {len(CAMERAS)} cameras rendering"


def rendering(inject: Callable[[LiveStage], Shot], bound_ms: float, robot: CameraStage) -> Shot:
    """The fault, and how many pictures came just before it and until the hold.

    A miss counts only where the simulator kept its ticks until then.
    """
    shot = inject(robot)
    if shot.measured_ms is not None and shot.measured_ms > bound_ms:
        robot.in_time(shot.began_ns - BEFORE_NS, shot.ended_ns, f"{shot.measured_ms:.0f} ms")
    rate = robot.frames_a_second(shot.began_ns - BEFORE_NS, shot.ended_ns)
    if not rate:
        raise MachineLateError("no picture came just before")
    return replace(shot, also=rate)


ROWS = tuple(
    Row(number, fault + RENDERING, outcome, bound_ms, "cameras",
        partial(rendering, inject, bound_ms), measures, also="pictures a second")
    for number, fault, outcome, bound_ms, inject, measures in (
        (1, "gate killed", "hold; the gate starts latched", 150, kill_gate,
         "hold"),
        (4, "runner killed in mid-chunk", "its rows end with its heartbeats", 550, kill_runner,
         "hold"),
        (26, "operator stop in motion", "stops", STOP_MS, operator_stop, FROM_PUT),
    )
)  # fmt: skip
