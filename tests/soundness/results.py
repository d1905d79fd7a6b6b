"""All campaigns of one robot, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice

import numpy as np

from bench.measure_limits.driven_robot import DrivenRobot
from bench.measure_limits.episodes import episode
from tests.soundness.kinematic_campaign import KinematicCampaign, Soundness
from tests.soundness.lockstep_loop import LockstepLoop
from tests.soundness.simulated_campaign import Simulated, SimulatedCampaign
from tests.soundness.usability import Usability, demonstrate

RECORDED_TICKS = 400


@dataclass(frozen=True)
class Amount:
    """chunks to judge, rows to execute in the simulator, demonstrations to give."""

    chunks: int
    rows: int
    episodes: int
    recorded_ticks: int = RECORDED_TICKS


@dataclass(frozen=True)
class Results:
    """What one robot's campaigns found."""

    robot: str
    kinematic: Soundness
    simulated: Simulated
    usability: Usability


def run(robot: str, amount: Amount, on_progress: Callable[[str], None]) -> Results:
    """Judge and follow, execute, demonstrate."""
    driven = DrivenRobot(robot)
    recorded = list(islice(episode(driven, 0), amount.recorded_ticks))
    rows = [tick.commands for tick in recorded]
    around = np.stack([tick.before.positions for tick in recorded])
    kinematic = KinematicCampaign(driven.robot, rows, around).run(amount.chunks, on_progress)
    loop = LockstepLoop(driven)
    try:
        simulated = SimulatedCampaign(loop, rows).run(amount.rows, on_progress)
        usability = demonstrate(loop, amount.episodes, on_progress)
    finally:
        loop.close()
    return Results(robot, kinematic, simulated, usability)
