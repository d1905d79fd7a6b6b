"""The HAL of robosuite simulators, ``run: hal_sim`` in a deployment file.

The names below are for fairlead's own tools; those that load robosuite do so when they are first
used. Robots are connected through `fairlead.hal`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from fairlead_hal_sim.hal_options import read_options
from fairlead_hal_sim.options import SimulatorOptions

if TYPE_CHECKING:
    from fairlead_hal_sim.environment import gripper_names, make_environment
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

__all__ = [
    "RobosuiteBackend",
    "SimulatorOptions",
    "gripper_names",
    "make_environment",
    "read_options",
]
_HOME = {
    "RobosuiteBackend": "robosuite_backend",
    "gripper_names": "environment",
    "make_environment": "environment",
}


def __getattr__(name: str) -> object:
    """Load a name that needs robosuite from its module when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
