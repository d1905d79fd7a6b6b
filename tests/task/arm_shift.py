"""What the composite switch does to an arm that is told to stay while the base turns."""

from __future__ import annotations

import numpy as np

from bench.equipment.expert_episode import true_state
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

STAY = PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", np.zeros(6), ())
"""An arm told nothing at all holds at its joints: to the switch it has to be told a row."""


def mode(value: float) -> dict[str, PartCommand]:
    switch = PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([value]), ())
    return {"composite": switch, "arm": STAY}


def arm_shift_after_turning(backend: RobosuiteBackend, switch: float) -> float:
    """How far the arm is off in the base frame after a turn of the base [m]."""
    backend.reset(0)
    backend.apply({})
    before = true_state(backend)[:3]
    rates = np.zeros(11)
    rates[2] = 1.0
    turning = {"base": PartCommand(ControlMode.JOINT_VELOCITY, "", rates, (2,))}
    for _ in range(20):
        backend.apply({**turning, **mode(switch)})
    for _ in range(20):
        backend.apply(mode(switch))
    return float(np.linalg.norm(true_state(backend)[:3] - before))
