"""The two cameras over the robot's shoulders that RoboCasa's checkpoints were trained with.

RoboCasa hangs them on the body that carries the arm, 0.5 m behind it, 0.35 m to each side
and 1.05 m above, looking forwards, 32.5 degrees down and 12.1 degrees inwards. They move with
the base and have no mass, so physics does not see them. The third camera of those
checkpoints, ``robot0_eye_in_hand``, is robosuite's own. Poses and field of view are those
of ``robocasa/utils/camera_utils.py``, without the noise some of its data sets add.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as ET

POSE_OF_CAMERA = {
    "robot0_agentview_left": ("-0.5 0.35 1.05", "0.55623853 0.29935253 -0.37678665 -0.6775092"),
    "robot0_agentview_right": ("-0.5 -0.35 1.05", "0.6775092 0.37678665 -0.29935253 -0.55623853"),
}
"""Camera -> position [m] and quaternion (wxyz) in the body that carries the arm."""

FOVY_DEG = "60"


def mount_robocasa_cameras(robot_model: Any) -> None:
    """Add the cameras to a robot's model; one without an Omron base does not get them."""
    name = f"{robot_model.base.naming_prefix}support"
    carrier = robot_model.worldbody.find(f".//body[@name='{name}']")
    if carrier is None:
        return
    for camera, (position, quat_wxyz) in POSE_OF_CAMERA.items():
        pose = {"mode": "fixed", "pos": position, "quat": quat_wxyz, "fovy": FOVY_DEG}
        ET.SubElement(carrier, "camera", {"name": camera, **pose})
