"""The ROS 2 HAL, as deployment files name it: ``run: hal_ros2``."""

from __future__ import annotations

from fairlead.hal.process import Equipment, HalDriver
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_ros2.options import Ros2Options


def _equip(robot: RobotManifest, profile: str, options: Ros2Options) -> Equipment:
    from fairlead_hal_ros2.ros2_backend import Ros2Backend  # needs the extra `ros2`

    return Equipment(Ros2Backend(robot, profile, options))


DRIVER = HalDriver(Ros2Options, _equip, realtime_only=True)
