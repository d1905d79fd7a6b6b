"""Poses from the wire's numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from fairlead.errors import MessageError
from fairlead.messages import floats

SE3 = Any  # pinocchio.SE3, which has no type stubs


def decode_pose(child: str, translation: bytes, rotation_xyzw: bytes) -> SE3:
    """Decode T_parent_child; refused with `MessageError` like `pose_from`."""
    xyz, quaternion = floats(translation), floats(rotation_xyzw)
    if xyz.shape != (3,) or quaternion.shape != (4,):
        raise MessageError(
            f"transform of {child!r}: expected 3 + 4 numbers, got {xyz.size} + {quaternion.size}"
        )
    return pose_from(child, xyz, quaternion)


def pose_from(child: str, translation: Any, rotation_xyzw: Any) -> SE3:
    """A `pinocchio.SE3` from xyz [m] and a unit quaternion xyzw.

    Raises:
        MessageError: naming ``child`` if a number is not finite or the quaternion's
            length is not 1 to 1e-6.
    """
    length = float(np.linalg.norm(rotation_xyzw))
    if not (np.all(np.isfinite(translation)) and abs(length - 1.0) <= 1e-6):
        raise MessageError(
            f"transform of {child!r}: expected finite numbers and a unit quaternion, got "
            f"{list(map(float, translation))}, {list(map(float, rotation_xyzw))}"
        )
    x, y, z, w = rotation_xyzw
    return pin.SE3(pin.Quaternion(w, x, y, z).toRotationMatrix(), np.asarray(translation))
