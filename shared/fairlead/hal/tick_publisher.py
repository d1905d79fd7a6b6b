"""Publishes everything measured at one tick, in order, as often as it takes."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from fairlead.frames import ODOM
from fairlead.hal.backend import FramePose, Measurement, TaskReading
from fairlead.hal.host_settings import HostSettings
from fairlead.messages import (
    Acted,
    HalCamera,
    Image,
    JointState,
    TaskState,
    Transform,
    TransformBatch,
    encode,
    pack_floats,
)
from fairlead.wire.bus import Bus, Publisher, Qos

STATIC_INTERVAL_NS = 1_000_000_000
"""Static transforms are sent again this often, so that a late joiner gets them."""
STATES_REMEMBERED = 16
"""Joint states that may come back to their sender, as a session's own do."""


class TickPublisher:
    """Transforms, due frames and the task's state first, ``state/joints`` last.

    A reader that has joints n therefore has, or is owed, all of n. What was published is
    kept encoded: a repeat sends the identical bytes.

    Args:
        settings: the service's name is its publisher name for transforms. Where a localiser
            is named, ``odom`` is that one's to place, whatever the backend says of it.
        cameras: those that may send frames.
    """

    def __init__(self, bus: Bus, settings: HostSettings, cameras: Sequence[HalCamera]) -> None:
        keys = settings.keys
        self._session = settings.session
        self._localiser = settings.localiser
        self._tf = bus.publisher(keys.tf(settings.service), TransformBatch, Qos.HOT)
        self._joints = bus.publisher(keys.joints, JointState, Qos.HOT)
        self._task = bus.publisher(keys.task, TaskState, Qos.STATUS)
        self._cameras = {
            camera.name: bus.publisher(keys.camera(camera.name), Image, Qos.CAMERA)
            for camera in cameras
        }
        self._told: deque[bytes] = deque(maxlen=STATES_REMEMBERED)
        self._static = b""
        self._static_due_ns = 0
        self._sent: list[tuple[Publisher, bytes]] = []
        self._frames: dict[str, bytes] = {}  # each camera's newest of this episode

    def set_static(self, tick: int, transforms: Sequence[FramePose]) -> None:
        """Take the transforms that never change in this episode; sent with the next tick."""
        self._static = encode(self._batch(tick, is_static=True, transforms=transforms))
        self._static_due_ns = 0
        self._frames = {}

    def begin(self, tick: int, transforms: Sequence[FramePose], now_ns: int) -> None:
        """Start a tick: send its transforms (and the static ones if they are due)."""
        self._sent = []
        if now_ns >= self._static_due_ns:
            self._put_static(now_ns)
        self._put(self._tf, encode(self._batch(tick, is_static=False, transforms=transforms)))

    def frame(self, image: Image) -> None:
        """Send one camera frame of the current tick; repeated until the camera's next one."""
        self._frames[image.camera] = encode(image)
        self._cameras[image.camera].put_bytes(self._frames[image.camera])

    def late_frame(self, image: Image) -> None:
        """Send a frame that was finished after its tick (realtime); never repeated."""
        self._cameras[image.camera].put(image)

    def finish(
        self,
        tick: int,
        episode_tick: int,
        stamp_ns: int,
        measured: Measurement,
        acted: Sequence[Acted],
        robot_hash: bytes,
        task: TaskReading | None,
    ) -> None:
        """Send the task's state and, last, the joint state."""
        if task is not None:
            state = TaskState(
                session=self._session,
                tick=tick,
                episode_tick=episode_tick,
                success=task.success,
                metrics=tuple((name, float(value)) for name, value in task.metrics.items()),
            )
            self._put(self._task, encode(state))
        joints = JointState(
            session=self._session,
            tick=tick,
            episode_tick=episode_tick,
            stamp_ns=stamp_ns,
            positions=pack_floats(measured.positions),
            velocities=pack_floats(measured.velocities),
            efforts=pack_floats(measured.efforts),
            acted=tuple(acted),
            robot_hash=robot_hash,
        )
        payload = encode(joints)
        self._told.append(payload)  # before it is sent: it may come back at once
        self._put(self._joints, payload)

    def is_own(self, payload: bytes) -> bool:
        """Whether a joint state is one that this HAL has sent, of late. Any thread may ask."""
        return payload in tuple(self._told)

    def repeat(self, now_ns: int) -> None:
        """Send the whole tick again: static transforms too, joints last, identical bytes.

        With each camera's newest frame, also of an earlier tick: who begins now has missed it.
        """
        self._put_static(now_ns)
        for camera, payload in self._frames.items():
            self._cameras[camera].put_bytes(payload)
        for publisher, payload in self._sent:
            publisher.put_bytes(payload)

    def _put(self, publisher: Publisher, payload: bytes) -> None:
        self._sent.append((publisher, payload))
        publisher.put_bytes(payload)

    def _put_static(self, now_ns: int) -> None:
        self._static_due_ns = now_ns + STATIC_INTERVAL_NS
        self._tf.put_bytes(self._static)

    def _batch(
        self, tick: int, *, is_static: bool, transforms: Sequence[FramePose]
    ) -> TransformBatch:
        return TransformBatch(
            session=self._session,
            tick=tick,
            is_static=is_static,
            transforms=tuple(
                Transform(
                    parent=pose.parent,
                    child=pose.child,
                    translation=pack_floats(pose.translation),
                    rotation_xyzw=pack_floats(pose.rotation_xyzw),
                )
                for pose in transforms
                if not (self._localiser and pose.child == ODOM)
            ),
        )
