"""Transforms from `tf2_msgs/TFMessage`, such as where a localiser or a tracker sees something."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import FramePose
from fairlead.ros2.messages import stamp_ns_of
from fairlead_hal_ros2.joint_states import Lateness

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


class Frames:
    """The newest pose of each wanted frame, since it was last asked for.

    A pose is dropped whose stamp is not newer than that of the one before, or that was under way
    for too long: it is no measurement of now.

    Args:
        parents: of each wanted frame, as the ROS 2 system has it.
        stale_after_s: how long one may be under way, beyond the quickest.
    """

    def __init__(self, parents: Mapping[str, str], stale_after_s: float) -> None:
        self._parents, self._stale_after_s = parents, stale_after_s
        self._new: dict[str, FramePose] = {}  # single steps only, so without a lock
        self._stamps_ns: dict[str, int] = {}
        self._lateness: dict[str, Lateness] = {}

    def take(self, message: Any, now_s: float) -> None:
        """Keep the wanted ones of a message that came now.

        Raises:
            MessageError: a wanted one has another parent, or numbers that are no pose.
        """
        for stamped in message.transforms:
            child, parent = stamped.child_frame_id, stamped.header.frame_id
            if child not in self._parents:
                continue
            if parent != self._parents[child]:
                what = f"parent {self._parents[child]!r}"
                raise MessageError(expected(f"tf: {child}", what, repr(parent)))
            stamp_ns = stamp_ns_of(stamped.header)
            if 0 < stamp_ns <= self._stamps_ns.get(child, 0):
                continue
            self._stamps_ns[child] = stamp_ns
            late_s = self._lateness.setdefault(child, Lateness()).of(stamp_ns, now_s)
            if late_s > self._stale_after_s:
                continue
            pose = stamped.transform
            self._new[child] = frame_pose(parent, child, pose.translation, pose.rotation)

    def new(self) -> list[FramePose]:
        """What came since the last call."""
        return [self._new.pop(child) for child in list(self._new)]
