"""The HAL of robosuite simulators, ``run: hal_sim`` in a deployment file.

The names below are for fairlead's own tools. Each loads when it is first used: plain robosuite,
which runs the scene to compare with, loads nothing else of the HAL. Robots are connected through
`fairlead.hal`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fairlead_hal_sim.camera_process import CameraProcess, start_camera_process
    from fairlead_hal_sim.environment import gripper_names, make_environment
    from fairlead_hal_sim.options import HalSimOptions, SimulatorOptions
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

__all__ = [
    "CameraProcess",
    "HalSimOptions",
    "RobosuiteBackend",
    "SimulatorOptions",
    "gripper_names",
    "make_environment",
    "start_camera_process",
]
_HOME = {
    "CameraProcess": "camera_process",
    "HalSimOptions": "options",
    "RobosuiteBackend": "robosuite_backend",
    "SimulatorOptions": "options",
    "gripper_names": "environment",
    "make_environment": "environment",
    "start_camera_process": "camera_process",
}


def __getattr__(name: str) -> object:
    """Load a public name from its module when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
