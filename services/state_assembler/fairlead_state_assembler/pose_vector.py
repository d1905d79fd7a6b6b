"""Poses and fingers as the numbers policies are trained on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pinocchio as pin

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_decoding import SE3

QuaternionOrder = Literal["xyzw", "wxyz"]


def rotation4(pose: SE3, order: QuaternionOrder) -> FloatArray:
    """The rotation as a unit quaternion in ``order``, with w >= 0: shape ``[4]``."""
    xyzw: FloatArray = pin.Quaternion(pose.rotation).coeffs()
    if xyzw[3] < 0.0:
        xyzw = -xyzw
    return xyzw if order == "xyzw" else np.roll(xyzw, 1)


def pose7(pose: SE3, order: QuaternionOrder) -> FloatArray:
    """Position [m], then quaternion: shape ``[7]``."""
    return np.concatenate((pose.translation, rotation4(pose, order)))


def gripper_pair(names: Sequence[str], joints: JointPositions) -> FloatArray:
    """Both fingers [m]: two joints as measured, or one joint v as ``[v, -v]``.

    Raises:
        LayoutError: ``missing_joint``, for any other number of joints or an unknown one.
    """
    if len(names) == 2:
        return np.array([joints.position(names[0]), joints.position(names[1])])
    if len(names) == 1:
        value = joints.position(names[0])
        return np.array([value, -value])
    raise LayoutError(
        f"gripper_qpos_joints: expected one or two joints, got {list(names)}",
        kind="missing_joint",
        name="gripper_qpos_joints",
    )
