"""The HAL of SO-101 arms, as deployment files name it: ``run: hal_so101``."""

from __future__ import annotations

from fairlead.hal.process import Equipment, HalDriver
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_so101.calibration import load_calibration
from fairlead_hal_so101.options import So101Options
from fairlead_hal_so101.so101_backend import So101Backend


def _equip(robot: RobotManifest, profile: str, options: So101Options) -> Equipment:
    calibration = load_calibration(options.calibration, robot)
    backend = So101Backend(robot, profile, options, calibration)
    return Equipment(backend, frames=backend)


DRIVER = HalDriver(So101Options, _equip, realtime_only=True)
