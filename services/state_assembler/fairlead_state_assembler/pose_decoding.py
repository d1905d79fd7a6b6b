"""Poses from the wire's numbers."""

from __future__ import annotations

import math
from typing import Any

import pinocchio as pin

from fairlead.errors import MessageError
from fairlead.messages import floats

SE3 = Any  # pinocchio.SE3, which has no type stubs


def decode_pose(child: str, translation: bytes, rotation_xyzw: bytes) -> SE3:
    """Decode T_parent_child; refused with `MessageError` like `pose_from`."""
    return pose_from(child, floats(translation).tolist(), floats(rotation_xyzw).tolist())


def pose_from(child: str, translation: Any, rotation_xyzw: Any) -> SE3:
    """A `pinocchio.SE3` from xyz [m] and a unit quaternion xyzw.

    Raises:
        MessageError: naming ``child`` if these are not 3 + 4 numbers, one is not finite, or the
            quaternion's length is not 1 to 1e-6.
    """
    xyz, quaternion = tuple(map(float, translation)), tuple(map(float, rotation_xyzw))
    if (len(xyz), len(quaternion)) != (3, 4):
        raise MessageError(
            f"transform of {child!r}: expected 3 + 4 numbers, got {len(xyz)} + {len(quaternion)}"
        )
    if not (all(map(math.isfinite, xyz)) and abs(math.hypot(*quaternion) - 1.0) <= 1e-6):
        raise MessageError(
            f"transform of {child!r}: expected finite numbers and a unit quaternion, got "
            f"{list(xyz)}, {list(quaternion)}"
        )
    return pin.XYZQUATToSE3(xyz + quaternion)
