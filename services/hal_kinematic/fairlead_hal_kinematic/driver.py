"""The HAL without physics, as deployment files name it: ``run: hal_kinematic``."""

from __future__ import annotations

from fairlead.hal.process import Equipment, HalDriver
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend
from fairlead_hal_kinematic.options import KinematicOptions


def _equip(robot: RobotManifest, profile: str, options: KinematicOptions) -> Equipment:
    backend = KinematicBackend(robot, profile, options.frames)
    backend.reset(options.seed)
    return Equipment(backend, trace=backend if options.trace else None)


DRIVER = HalDriver(KinematicOptions, _equip, simulator=True)
