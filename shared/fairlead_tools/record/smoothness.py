"""How smoothly a run's rows followed one another: stalls, and steps from chunk to chunk."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fairlead.messages import Hold
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.record.measured import Curve
from fairlead_tools.record.part_series import panels
from fairlead_tools.record.run_log import Run


@dataclass(frozen=True)
class Smoothness:
    """stalls: how often the released rows ran out before the last of them.

    seam_step: the largest change of a commanded number from one chunk's last row to the next
    chunk's first, as a share of that number's range in the run; None where no chunk follows one
    without a hold between them. Grippers and switches, which change at once, do not count.
    """

    stalls: int
    seam_step: float | None


def smoothness(run: Run, robot: RobotManifest) -> Smoothness:
    """Of a run that holds one goal's ticks."""
    chunk_of = _released(run)
    last = max(chunk_of, default=0)
    first = min(chunk_of, default=0)
    without_row = {
        state.tick - 1 for state in run.joints
        if first < state.tick - 1 < last and any(one.hold == Hold.NO_ROW for one in state.acted)
    }  # fmt: skip
    stalls = sum(tick - 1 not in without_row for tick in without_row)
    seams = [
        tick for tick, chunk in chunk_of.items()
        if tick - 1 in chunk_of and chunk_of[tick - 1] != chunk and tick not in without_row
    ]  # fmt: skip
    steps = [
        step for panel in panels(run, robot) if not panel.switches
        for step in _steps(panel.released, seams)
    ]  # fmt: skip
    return Smoothness(stalls, max(steps, default=None))


def _released(run: Run) -> dict[int, tuple[str, int, int]]:
    """Which chunk's row was released for each tick: the newest one's."""
    found = {}
    for chunk, ticks in run.released():
        found.update(dict.fromkeys(ticks, (chunk.source, chunk.claim_id, chunk.seq)))
    return found


def _steps(released: Curve, seams: list[int]) -> list[float]:
    released = {tick: value for tick, value in released.items() if not math.isnan(value)}
    span = max(released.values(), default=0.0) - min(released.values(), default=0.0)
    if span <= 0.0:
        return []
    both = [tick for tick in seams if tick in released and tick - 1 in released]
    return [abs(released[tick] - released[tick - 1]) / span for tick in both]
