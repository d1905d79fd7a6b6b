"""Joints, transforms, pictures and verdicts of a robot as ROS 2 topics, for RViz and rosbag."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from fairlead.keys import Keys, last_chunk
from fairlead.messages import (
    Image,
    JointState,
    Outcome,
    Transform,
    TransformBatch,
    Verdict,
    decode,
    floats,
)
from fairlead.ros2.messages import (
    COMPRESSED_IMAGE,
    DIAGNOSTIC_ARRAY,
    IMAGE,
    JOINT_STATE,
    TF_MESSAGE,
)
from fairlead.ros2.node import RosNode, RosPublisher
from fairlead.wire.bus import Bus, Sample
from fairlead.wire.topics import EVERY
from fairlead.wire.verdict_text import describe

TICKS_REMEMBERED = 64
ALWAYS = {
    "/joint_states": JOINT_STATE,
    "/tf": TF_MESSAGE,
    "/tf_static": TF_MESSAGE,
    "/diagnostics": DIAGNOSTIC_ARRAY,
}
LEVELS = {Outcome.RELEASED: 0, Outcome.TRUNCATED: 1, Outcome.REFUSED: 2}  # OK, WARN, ERROR
RAW = {"rgb8": ("rgb8", 3), "depth32f": ("32FC1", 4)}
"""How ROS 2 calls an encoding, and its bytes per pixel."""


class Ros2Bridge:
    """Publishes what it hears until its node and its bus are closed; it only listens.

    All of one tick has one stamp: this machine's clock when the first of it came.

    Args:
        joints: names of the joints in wire order.
        prefix: before every topic; "" for none.
    """

    def __init__(
        self, bus: Bus, keys: Keys, joints: tuple[str, ...], node: RosNode, prefix: str = ""
    ) -> None:
        self._joints, self._types = list(joints), node.types
        self._publisher: Callable[[str, str], RosPublisher] = cache(
            lambda topic, kind: node.publisher(prefix + topic, kind)
        )
        for topic, kind in ALWAYS.items():  # said to be there before the first message comes
            self._publisher(topic, kind)
        self._stamps: dict[tuple[int, int], int] = {}
        self._newest: dict[str, tuple[int, int]] = {}
        handlers: dict[str, Callable[[Sample], None]] = {
            keys.joints: self._on_joints,
            keys.every_tf: self._on_transforms,
            keys.camera(EVERY): self._on_image,
            keys.every_verdict: self._on_verdict,
        }
        for key, handler in handlers.items():
            bus.subscribe(key, handler)

    def _on_joints(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        if self._is_repeated(sample.key, state):
            return
        blocks = (state.positions, state.velocities, state.efforts)
        position, velocity, effort = (np.array(floats(block)) for block in blocks)
        message = self._types.make(
            JOINT_STATE,
            header=self._types.header(self._stamp_ns(state)),
            name=self._joints,
            position=position,
            velocity=velocity,
            effort=effort,
        )
        self._publisher("/joint_states", JOINT_STATE).publish(message)

    def _on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        if batch.is_static:
            topic, stamp_ns = "/tf_static", time.time_ns()
        elif self._is_repeated(sample.key, batch) or not batch.transforms:
            return
        else:
            topic, stamp_ns = "/tf", self._stamp_ns(batch)
        stamped = [self._transform(one, stamp_ns) for one in batch.transforms]
        self._publisher(topic, TF_MESSAGE).publish(self._types.make(TF_MESSAGE, transforms=stamped))

    def _transform(self, transform: Transform, stamp_ns: int) -> Any:
        make = self._types.make
        place, turn = floats(transform.translation), floats(transform.rotation_xyzw)
        pose = make(
            "geometry_msgs/msg/Transform",
            translation=make("geometry_msgs/msg/Vector3", **dict(zip("xyz", place, strict=True))),
            rotation=make("geometry_msgs/msg/Quaternion", **dict(zip("xyzw", turn, strict=True))),
        )
        return make(
            "geometry_msgs/msg/TransformStamped",
            header=self._types.header(stamp_ns, transform.parent),
            child_frame_id=transform.child,
            transform=pose,
        )

    def _on_image(self, sample: Sample) -> None:
        image = decode(Image, sample.payload)
        if self._is_repeated(sample.key, image):
            return
        topic = f"/camera/{ros_name(image.camera)}/image_raw"
        header = self._types.header(self._stamp_ns(image), image.camera)
        data = np.frombuffer(image.data, dtype=np.uint8)
        if image.encoding_name == "jpeg":
            message = self._types.make(COMPRESSED_IMAGE, header=header, format="jpeg", data=data)
            self._publisher(f"{topic}/compressed", COMPRESSED_IMAGE).publish(message)
            return
        encoding, size = RAW[image.encoding_name]
        message = self._types.make(
            IMAGE,
            header=header,
            height=image.height,
            width=image.width,
            encoding=encoding,
            is_bigendian=0,
            step=size * image.width,
            data=data,
        )
        self._publisher(topic, IMAGE).publish(message)

    def _on_verdict(self, sample: Sample) -> None:
        verdict, make = decode(Verdict, sample.payload), self._types.make
        outcome = Outcome(verdict.outcome)
        rows = f"rows {verdict.released_first} to {verdict.released_last}"
        said = describe(verdict) if verdict.code else f"chunk {verdict.seq} released: {rows}"
        values = {name: str(getattr(verdict, name)) for name in ("seq", "code", "part", "axis")}
        status = make(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=LEVELS[outcome],
            name=f"fairlead gate: {last_chunk(sample.key)}",
            message=said,
            hardware_id="",
            values=[
                make("diagnostic_msgs/msg/KeyValue", key=key, value=value)
                for key, value in values.items()
            ],
        )
        header = self._types.header(time.time_ns())
        message = make(DIAGNOSTIC_ARRAY, header=header, status=[status])
        self._publisher("/diagnostics", DIAGNOSTIC_ARRAY).publish(message)

    def _is_repeated(self, key: str, message: JointState | TransformBatch | Image) -> bool:
        """Whether it came before: a world that waits sends its tick again."""
        tick = (message.session, message.tick)
        before, self._newest[key] = self._newest.get(key), tick
        return before == tick

    def _stamp_ns(self, message: JointState | TransformBatch | Image) -> int:
        tick = (message.session, message.tick)
        stamp_ns = self._stamps.setdefault(tick, time.time_ns())
        for old in list(self._stamps)[:-TICKS_REMEMBERED]:
            self._stamps.pop(old, None)
        return stamp_ns


def ros_name(name: str) -> str:
    """A name of ours as one that ROS 2 takes: letters, digits and ``_``, no digit first."""
    taken = re.sub(r"\W", "_", name)
    return f"_{taken}" if taken[0].isdigit() else taken
