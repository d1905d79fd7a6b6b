"""Poses in ROS 2 messages."""

from __future__ import annotations

from typing import Any

import numpy as np

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import FramePose

UNIT_TOLERANCE = 1e-3
"""How far from length 1 a quaternion may be: some senders have float32."""


def frame_pose(parent: str, child: str, place: Any, turn: Any) -> FramePose:
    """T_parent_child of a vector with x, y, z and a quaternion with x, y, z, w.

    Raises:
        MessageError: they are no pose.
    """
    xyz = np.array([place.x, place.y, place.z])
    xyzw = np.array([turn.x, turn.y, turn.z, turn.w])
    length = float(np.linalg.norm(xyzw))
    if not np.isfinite(xyz).all() or not abs(length - 1.0) <= UNIT_TOLERANCE:
        what = "finite numbers and a unit quaternion"
        raise MessageError(expected(f"pose of {child}", what, [*xyz.tolist(), *xyzw.tolist()]))
    return FramePose(parent, child, xyz, xyzw / length)
