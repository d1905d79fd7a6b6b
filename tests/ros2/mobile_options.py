"""Options of hal_ros2 for panda_mobile's base and gripper."""

from __future__ import annotations

from typing import Any

from fairlead.checked_model import checked_model
from fairlead_hal_ros2.options import Ros2Options
from tests.ros2.ros_process import NAMES

BASE = ("base_x", "base_y", "base_yaw")


def mobile_options(router: str, **changes: Any) -> Ros2Options:
    data = {
        "router": router,
        "joints": NAMES,
        "parts": {"gripper": {"positions": "/gripper/commands"}},
        "base": {"child_frame": "base_footprint"},
        "frames": {"object": "map"},
        "without_effort": [*BASE, "torso_height"],
    }
    return checked_model("options", Ros2Options, data | changes)
