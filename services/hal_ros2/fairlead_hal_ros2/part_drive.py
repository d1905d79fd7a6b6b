"""Joint positions of a part as its controller in the ROS 2 system takes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fairlead.messages import FloatArray
from fairlead.ros2.messages import FLOAT64_MULTI_ARRAY, JOINT_TRAJECTORY
from fairlead.ros2.node import RosNode
from fairlead_hal_ros2.joint_states import JointSource
from fairlead_hal_ros2.options import PartTopic


class PartDrive:
    """One part's command topic.

    Attributes:
        topic, kind: where its commands go, and of which type they are.

    Args:
        joints: of the part, as indices into the robot's joints.
        sources: of these joints.
    """

    def __init__(
        self,
        node: RosNode,
        topic: PartTopic,
        joints: Sequence[int],
        sources: Sequence[JointSource],
        period_ns: int,
    ) -> None:
        self.topic = topic.trajectory or topic.positions or ""
        self.kind = JOINT_TRAJECTORY if topic.trajectory else FLOAT64_MULTI_ARRAY
        self.joints, self._sources = list(joints), list(sources)
        self._types, self._period_ns = node.types, period_ns
        self._publisher = node.publisher(self.topic, self.kind)

    def send(self, setpoints: FloatArray) -> None:
        """Tell the part where its joints are to be a period from now.

        Args:
            setpoints: of all the robot's joints [rad or m].
        """
        positions = [
            share
            for joint, source in zip(self.joints, self._sources, strict=True)
            for share in source.shares(float(setpoints[joint]))
        ]
        self._publisher.publish(self._message(np.array(positions)))

    def _message(self, positions: FloatArray) -> Any:
        types = self._types
        if self.kind == FLOAT64_MULTI_ARRAY:
            layout = types.make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
            return types.make(self.kind, layout=layout, data=positions)
        none, seconds = np.zeros(0), divmod(self._period_ns, 10**9)
        point = types.make(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=positions,
            velocities=none,
            accelerations=none,
            effort=none,
            time_from_start=types.make(
                "builtin_interfaces/msg/Duration", sec=seconds[0], nanosec=seconds[1]
            ),
        )
        names = [name for source in self._sources for name in source.factors]
        return types.make(self.kind, header=types.header(0), joint_names=names, points=[point])
