"""Rotations and fingers as the numbers policies are trained on."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import pinocchio as pin

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray
from fairlead.skill.bindings import QuaternionSign
from fairlead_state_assembler.pose_decoding import SE3

QuaternionOrder = Literal["xyzw", "wxyz"]


def position3(pose: SE3) -> FloatArray:
    """The position [m]: shape ``[3]``."""
    position: FloatArray = pin.SE3ToXYZQUAT(pose)[:3]
    return position


def quaternion_xyzw(pose: SE3, sign: QuaternionSign) -> FloatArray:
    """The rotation as a unit quaternion xyzw, shape ``[4]``.

    Args:
        sign: the number that is never negative (``+``) or never positive (``-``).
    """
    return pose7(pose, "xyzw", sign)[3:]


def pose7(pose: SE3, order: QuaternionOrder, sign: QuaternionSign) -> FloatArray:
    """Position [m] and `rotation4`: shape ``[7]``."""
    numbers: FloatArray = pin.SE3ToXYZQUAT(pose)
    xyzw = numbers[3:]
    decides = xyzw.item("xyzw".index(sign[1]))
    if decides < 0.0 if sign[0] == "+" else decides > 0.0:
        np.negative(xyzw, xyzw)
    if order == "wxyz":
        xyzw[:] = np.roll(xyzw, 1)
    return numbers


def rotation4(pose: SE3, order: QuaternionOrder, sign: QuaternionSign) -> FloatArray:
    """The rotation as a unit quaternion in ``order``: shape ``[4]``."""
    return pose7(pose, order, sign)[3:]


def axis_angle3(pose: SE3, sign: QuaternionSign) -> FloatArray:
    """The rotation as unit axis times angle [rad]: shape ``[3]``.

    The angle is that of the quaternion with ``sign``: at most pi for ``+w``, up to 2 pi
    for the others. No rotation is the zero vector.
    """
    xyzw = quaternion_xyzw(pose, sign)
    sine = float(np.linalg.norm(xyzw[:3]))
    if sine == 0.0:
        return np.zeros(3)
    # atan2 instead of acos: exact for small angles too.
    return xyzw[:3] * (2.0 * math.atan2(sine, xyzw[3]) / sine)


def gripper_pair(names: Sequence[str], measured: Callable[[str], float]) -> FloatArray:
    """Both fingers [m or m/s]: two joints as measured, or one joint v as ``[v, -v]``.

    Args:
        measured: the position or velocity of a joint.

    Raises:
        LayoutError: ``missing_joint``, for any other number of joints or an unknown one.
    """
    if len(names) == 2:
        return np.array([measured(names[0]), measured(names[1])])
    if len(names) == 1:
        value = measured(names[0])
        return np.array([value, -value])
    raise LayoutError(
        f"gripper_qpos_joints: expected one or two joints, got {list(names)}",
        kind="missing_joint",
        name="gripper_qpos_joints",
    )
