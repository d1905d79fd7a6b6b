"""Prints how many functions robosuite had compiled before a HAL's first row, and after it."""

from __future__ import annotations

import sys

import numpy as np
from numba.core.dispatcher import Dispatcher

from bench.equipment.expert_episode import commands
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend


def compiled() -> int:
    """Signatures of every function of robosuite's that numba has compiled or loaded by now."""
    modules = [module for name, module in sys.modules.items() if name.startswith("robosuite")]
    found = {value for m in modules for value in vars(m).values() if isinstance(value, Dispatcher)}
    return sum(len(function.signatures) for function in found)


if __name__ == "__main__":
    backend = RobosuiteBackend(SimulatorOptions())
    before = compiled()
    backend.apply(commands(np.full(12, 0.1, dtype=np.float32)))
    print(before, compiled())
