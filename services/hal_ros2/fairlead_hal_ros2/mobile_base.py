"""A mobile base: `nav_msgs/Odometry` in, `geometry_msgs/Twist` out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fairlead.errors import ConfigError, MessageError, expected
from fairlead.hal.backend import FramePose, PartCommand
from fairlead.hal.setpoints import SetpointLimits
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.ros2.messages import TWIST, MessageTypes, stamp_ns_of
from fairlead_hal_ros2.frames import frame_pose
from fairlead_hal_ros2.joint_states import Lateness
from fairlead_hal_ros2.options import BaseTopics

PLANE = [0, 1, 5]
"""Of a twist: what a base that drives in a plane can do, x, y and yaw."""


@dataclass(frozen=True)
class BaseState:
    """Where the base is in ``odom``: x, y [m], yaw over its turns [rad], and their rates.

    positions, velocities: shape ``[3]``, of the joints x, y and yaw: along the axes of ``odom``,
        and of the axis that the yaw turns about, where that is not the base frame's own.
    stamp_ns, arrived_s: as of `Reading`.
    """

    pose: FramePose
    positions: FloatArray
    velocities: FloatArray
    stamp_ns: int
    arrived_s: float


class Odometry:
    """The newest state of the base. `take` for one thread, `newest` for any."""

    def __init__(self, topics: BaseTopics, base_frame: str, yaw_axis: FloatArray) -> None:
        self._topics, self._base_frame, self._yaw_axis = topics, base_frame, yaw_axis
        self.newest: BaseState | None = None
        self._lateness = Lateness()

    def take(self, message: Any, now_s: float) -> None:
        """Keep a message, unless it is stamped no later than the one before.

        Raises:
            MessageError: it is about another frame, or has a number that is not finite.
        """
        if message.child_frame_id != self._topics.child_frame:
            wanted = f"child_frame_id {self._topics.child_frame!r} (option base.child_frame)"
            raise MessageError(expected("odometry", wanted, repr(message.child_frame_id)))
        pose = message.pose.pose
        there = frame_pose("odom", self._base_frame, pose.position, pose.orientation)
        twist = message.twist.twist
        rates = np.array([twist.linear.x, twist.linear.y, twist.angular.z])
        if not np.isfinite(rates).all():
            raise MessageError(expected("odometry", "a finite twist", rates.tolist()))
        stamp_ns = stamp_ns_of(message.header)
        if self.newest is not None and 0 < stamp_ns <= self.newest.stamp_ns:
            return
        yaw = _yaw(there.rotation_xyzw)
        if self.newest is not None:  # over its turns: the nearest to where it was
            yaw += 2 * np.pi * np.round((self.newest.positions[2] - yaw) / (2 * np.pi))
        axis = _turned(self._yaw_axis, yaw)
        self.newest = BaseState(
            there,
            np.array([*(there.translation[:2] + axis - self._yaw_axis), yaw]),
            np.array([*(_turned(rates[:2], yaw) + rates[2] * _across(axis)), rates[2]]),
            stamp_ns,
            now_s - self._lateness.of(stamp_ns, now_s),
        )


class BaseDrive:
    """Twists of the base. A base that is not commanded slows down by its acceleration limits.

    Args:
        robot: with ``base_joints`` x, y and yaw.
        profile: the safety profile whose limits these are.
        yaw_axis: where the base turns, in its own frame [m]; shape ``[2]``.
    """

    def __init__(self, robot: RobotManifest, profile: str, yaw_axis: FloatArray) -> None:
        self._joints = [robot.joint_names.index(name) for name in robot.base_joints]
        self._yaw_axis = yaw_axis
        slowing = SetpointLimits(robot, profile).slowing[self._joints]
        self._slowing = slowing * robot.tick_period_ns * 1e-9
        self._rates = np.zeros(3)

    def advance(self, command: PartCommand | None, yaw: float) -> FloatArray:
        """x, y [m/s] and yaw [rad/s] along the base's own axes for the next period.

        Raises:
            ConfigError: a twist out of the plane.
        """
        if command is None:
            slower = np.maximum(np.abs(self._rates) - self._slowing, 0.0)
            self._rates = np.sign(self._rates) * slower
        elif command.mode is ControlMode.BODY_TWIST:
            if np.delete(command.values, PLANE).any():
                what = "a twist in the plane"
                raise ConfigError(expected("hal_ros2: base", what, command.values.tolist()))
            self._rates = command.values[PLANE].copy()
        else:
            rates = command.values[self._joints]
            own = _turned(rates[:2], -yaw) - rates[2] * _across(self._yaw_axis)
            self._rates = np.array([*own, rates[2]])
        return self._rates


def twist_message(types: MessageTypes, rates: FloatArray) -> Any:
    """A `TWIST` of x, y and yaw."""
    x, y, yaw = map(float, rates)
    vector = "geometry_msgs/msg/Vector3"
    return types.make(
        TWIST,
        linear=types.make(vector, x=x, y=y, z=0.0),
        angular=types.make(vector, x=0.0, y=0.0, z=yaw),
    )


def _yaw(xyzw: FloatArray) -> float:
    x, y, z, w = xyzw
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def _across(vector: FloatArray) -> FloatArray:
    """How the tip of a vector moves that turns with 1 rad/s."""
    return np.array([-vector[1], vector[0]])


def _turned(vector: FloatArray, angle: float) -> FloatArray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]]) @ vector
