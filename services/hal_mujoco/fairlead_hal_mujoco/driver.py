"""The plain MuJoCo HAL, as deployment files name it: ``run: hal_mujoco``."""

from __future__ import annotations

from fairlead.hal.process import Equipment, HalDriver
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions


def _equip(robot: RobotManifest, profile: str, options: MujocoOptions) -> Equipment:
    backend = MujocoBackend(robot, profile, options)
    trace = backend if options.trace else None
    return Equipment(backend, trace=trace, frames=backend.frames())


DRIVER = HalDriver(MujocoOptions, _equip, simulator=True)
