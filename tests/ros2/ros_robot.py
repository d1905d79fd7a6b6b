"""A small robot that speaks ROS 2 on rmw_zenoh, by another's implementation of it.

    python -m tests.ros2.ros_robot '{"port": 7447, "domain": 0, "joints": {"joint1": 0.1}, ...}'

Its joints move to their targets on a straight line in the time they are given, its base as it is
told. Lines on standard input change it: ``mute``, ``speak``, ``effortless``. On standard output it
writes a JSON line for each command that it gets.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.utils import get_type_hash

STORE = get_typestore(Stores.ROS2_JAZZY)
PERIOD_S = 0.01
SILENCE_S = 0.5
"""A base that hears no twist for so long stops."""


def definition(kind: str) -> str:
    """The text of a message type with those of all it is made of."""
    return STORE.generate_msgdef(kind, ros_version=2)[0]


def type_hash(kind: str) -> str:
    """As the other implementation computes it from the texts."""
    own, *others = definition(kind).split("=" * 80 + "\nMSG: ")
    named = (text.partition("\n") for text in others)
    known = {name.replace("/", "/msg/"): text for name, _, text in named}
    return str(get_type_hash(kind, msg_definition=own, dependencies=known))


def made(kind: str, **fields: Any) -> Any:
    return STORE.types[kind](**fields)


def say(what: dict[str, object]) -> None:
    """One line in one piece, from whichever thread."""
    os.write(1, json.dumps(what).encode() + b"\n")


@dataclass
class Axis:
    """A joint on its way."""

    start: float
    end: float
    began_s: float = 0.0
    takes_s: float = 0.0

    def at(self, now_s: float) -> float:
        share = 1.0 if self.takes_s == 0.0 else min((now_s - self.began_s) / self.takes_s, 1.0)
        return self.start + share * (self.end - self.start)

    def go(self, end: float, takes_s: float, now_s: float) -> None:
        self.start, self.end = self.at(now_s), end
        self.began_s, self.takes_s = now_s, takes_s


class RosRobot:
    """Args: what it is told in JSON: port, domain, joints, trajectory, positions, base."""

    def __init__(self, told: dict[str, Any]) -> None:
        self._link = {"router_port": told["port"], "domain_id": told["domain"]}
        self._link["node_name"] = "ros_robot"
        self.axes = {name: Axis(value, value) for name, value in told["joints"].items()}
        self.muted, self.effortless = False, False
        self._pose, self._rates, self._told_s = np.zeros(3), np.zeros(3), 0.0
        self._base = bool(told.get("base"))
        self._positions = list(told.get("positions", ()))
        self._states = self._publisher("/joint_states", "sensor_msgs/msg/JointState")
        self._subscriptions = [
            self._hear("/arm/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", self._walk)
        ]
        if self._positions:
            kind = "std_msgs/msg/Float64MultiArray"
            self._subscriptions.append(self._hear("/gripper/commands", kind, self._jump))
        if self._base:
            self._odometry = self._publisher("/odom", "nav_msgs/msg/Odometry")
            self._subscriptions.append(
                self._hear("/cmd_vel", "geometry_msgs/msg/Twist", self._drive)
            )
        if told.get("tf"):
            self._tf = self._publisher("/tf", "tf2_msgs/msg/TFMessage")
        self._has_tf = bool(told.get("tf"))

    def _publisher(self, topic: str, kind: str) -> Any:
        text = definition(kind)
        return ROS2Publisher(topic, kind, text, type_hash=type_hash(kind), **self._link)

    def _hear(self, topic: str, kind: str, handler: Any) -> Any:
        text = definition(kind)
        return ROS2Subscriber(topic, kind, handler, text, type_hash=type_hash(kind), **self._link)

    def _walk(self, message: Any) -> None:
        [point] = message.points
        takes_s = point.time_from_start.sec + point.time_from_start.nanosec * 1e-9
        for name, end in zip(message.joint_names, point.positions, strict=True):
            self.axes[name].go(float(end), takes_s, time.monotonic())
        self._say("trajectory", point.positions, names=message.joint_names, takes_s=takes_s)

    def _jump(self, message: Any) -> None:
        for name, end in zip(self._positions, message.data, strict=True):
            self.axes[name].go(float(end), 0.05, time.monotonic())
        self._say("positions", message.data)

    def _drive(self, message: Any) -> None:
        linear, angular = message.linear, message.angular
        self._rates = np.array([linear.x, linear.y, angular.z])
        self._told_s = time.monotonic()
        self._say("twist", self._rates)

    def _say(self, what: str, values: Any, **more: object) -> None:
        say({"got": what, "values": [float(v) for v in values], **more})

    def step(self, before: dict[str, float]) -> dict[str, float]:
        """One period; positions of the joints."""
        now_s, stamp = time.monotonic(), time.time_ns()
        positions = {name: axis.at(now_s) for name, axis in self.axes.items()}
        header = made(
            "std_msgs/msg/Header",
            stamp=made("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9),
            frame_id="",
        )
        if not self.muted:
            self._states.publish(
                header=header,
                name=list(positions),
                position=np.array(list(positions.values())),
                velocity=np.array([(positions[n] - before[n]) / PERIOD_S for n in positions]),
                effort=np.zeros(0 if self.effortless else len(positions)),
            )
        if self._base:
            self._move_base(header, now_s)
        if self._has_tf:
            self._publish_tf(header)
        return positions

    def _move_base(self, header: Any, now_s: float) -> None:
        if now_s - self._told_s > SILENCE_S:
            self._rates = np.zeros(3)
        x, y, turn = self._rates * PERIOD_S
        c, s = np.cos(self._pose[2]), np.sin(self._pose[2])
        self._pose += [c * x - s * y, s * x + c * y, turn]
        vector, half = "geometry_msgs/msg/Vector3", self._pose[2] / 2
        x, y, turn = map(float, self._rates)
        twist = made(
            "geometry_msgs/msg/Twist",
            linear=made(vector, x=x, y=y, z=0.0),
            angular=made(vector, x=0.0, y=0.0, z=turn),
        )
        place = dict(zip("xy", map(float, self._pose[:2]), strict=True))
        pose = made(
            "geometry_msgs/msg/Pose",
            position=made("geometry_msgs/msg/Point", **place, z=0.0),
            orientation=made(
                "geometry_msgs/msg/Quaternion",
                x=0.0, y=0.0, z=float(np.sin(half)), w=float(np.cos(half)),
            ),
        )  # fmt: skip
        none = np.zeros(36)
        self._odometry.publish(
            header=header,
            child_frame_id="base_footprint",
            pose=made("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=none),
            twist=made("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=none),
        )

    def _publish_tf(self, header: Any) -> None:
        pose = made(
            "geometry_msgs/msg/Transform",
            translation=made("geometry_msgs/msg/Vector3", x=1.0, y=2.0, z=3.0),
            rotation=made("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        )
        header.frame_id = "map"
        self._tf.publish(
            transforms=[
                made(
                    "geometry_msgs/msg/TransformStamped",
                    header=header, child_frame_id=child, transform=pose,
                )
                for child in ("object", "unasked")
            ]
        )  # fmt: skip

    def obey(self) -> None:
        for line in sys.stdin:
            word = line.strip()
            if word in ("mute", "speak"):
                self.muted = word == "mute"
            self.effortless = word == "effortless" or self.effortless


def main() -> None:
    robot = RosRobot(json.loads(sys.argv[1]))
    threading.Thread(target=robot.obey, daemon=True).start()
    say({"got": "started", "values": []})
    positions = {name: axis.at(0.0) for name, axis in robot.axes.items()}
    due_s = time.monotonic()
    while True:
        positions = robot.step(positions)
        due_s += PERIOD_S
        time.sleep(max(0.0, due_s - time.monotonic()))


if __name__ == "__main__":
    main()
