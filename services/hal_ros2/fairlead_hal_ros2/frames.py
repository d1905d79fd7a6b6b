"""Transforms from `tf2_msgs/TFMessage`, such as where a localiser or a tracker sees something."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import FramePose
from fairlead_hal_ros2.poses import frame_pose


class Frames:
    """The newest pose of each wanted frame, since it was last asked for.

    Args:
        parents: of each wanted frame, as the ROS 2 system has it.
    """

    def __init__(self, parents: Mapping[str, str]) -> None:
        self._parents = parents
        self._new: dict[str, FramePose] = {}  # single steps only, so without a lock

    def take(self, message: Any) -> None:
        """Keep the wanted ones of a message.

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
            pose = stamped.transform
            self._new[child] = frame_pose(parent, child, pose.translation, pose.rotation)

    def new(self) -> list[FramePose]:
        """What came since the last call."""
        return [self._new.pop(child) for child in list(self._new)]
