"""Where a cartesian command wants the tool: a pose in the world."""

from __future__ import annotations

import mujoco
import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.hal.model_kinematics import Pose
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode


def tool_goal(command: PartCommand, tool: Pose, frame: Pose, period_s: float) -> Pose:
    """The tool's pose at the end of a period.

    cartesian_pose: the values are T_frame_tool. cartesian_delta: xyz and a rotation vector r
    along the frame's axes, applied at the tool's origin: R' = exp(r) R. cartesian_twist: the
    same, per second.

    Args:
        tool: where the tool is (or was told to be) now.
        frame: the command's frame_id.
        period_s: control period [s].
    """
    values = command.values
    if command.mode is ControlMode.CARTESIAN_POSE:
        position = frame.position + rotated(values[:3], frame)
        return Pose(position, product(frame.quaternion_wxyz, values[[6, 3, 4, 5]]))
    share = period_s if command.mode is ControlMode.CARTESIAN_TWIST else 1.0
    shift, turn = rotated(values[:3] * share, frame), rotated(values[3:] * share, frame)
    return Pose(tool.position + shift, product(rotation(turn), tool.quaternion_wxyz))


def motion_between(start: Pose, goal: Pose) -> FloatArray:
    """Shift [m] and rotation vector [rad] from one pose to another, world axes, shape [6]."""
    inverse, turn = np.zeros(4), np.zeros(3)
    mujoco.mju_negQuat(inverse, start.quaternion_wxyz)
    mujoco.mju_quat2Vel(turn, product(goal.quaternion_wxyz, inverse), 1.0)
    return np.concatenate([goal.position - start.position, turn])


def rotated(vector: FloatArray, frame: Pose) -> FloatArray:
    """A vector along the frame's axes, along the world's."""
    found = np.zeros(3)
    mujoco.mju_rotVecQuat(found, vector, frame.quaternion_wxyz)
    return found


def rotation(vector: FloatArray) -> FloatArray:
    """exp(vector) as a quaternion wxyz; ``vector`` in rad."""
    found, angle = np.zeros(4), float(np.linalg.norm(vector))
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    mujoco.mju_axisAngle2Quat(found, axis, angle)
    return found


def product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Quaternion product, wxyz."""
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, first, second)
    return found
