"""Drives of the robots that ship, and deflections for them."""

from __future__ import annotations

from fairlead.robot.manifest import load_robot
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.drive import Drive, make_drive


def drive(robot: str = "panda", part: str = "", mode: str = "") -> Drive:
    return make_drive(load_robot(robot), "sim", part, mode)


def asks(*axes: float, clutch: bool = True, speed: float = 1.0, age_s: float = 0.0) -> Deflection:
    return Deflection(axes=axes, clutch=clutch, speed=speed, age_s=age_s)
