"""Publishes everything of one tick: what was measured, in order, and the camera frames it owes."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Sequence

from fairlead.frames import ODOM
from fairlead.hal.backend import CameraFeed, FramePose, Measurement, TaskReading
from fairlead.hal.identity import HostSettings
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
    """Due frames, transforms and the task's state first, ``state/joints`` last.

    So all that belongs to tick n is sent before its joints, and at once: whoever hears the first of
    it takes processor time from us. What was published is kept encoded: a repeat sends the
    identical bytes.

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
        """Start a tick with its transforms (send the static ones if they are due)."""
        if now_ns >= self._static_due_ns:
            self._put_static(now_ns)
        batch = encode(self._batch(tick, is_static=False, transforms=transforms))
        self._sent = [(self._tf, batch)]

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
        """Send the transforms, the task's state and, last, the joint state."""
        if task is not None:
            state = TaskState(
                session=self._session,
                tick=tick,
                episode_tick=episode_tick,
                success=task.success,
                metrics=tuple((name, float(value)) for name, value in task.metrics.items()),
            )
            self._sent.append((self._task, encode(state)))
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
        self._sent.append((self._joints, payload))
        self._send()

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
        self._send()

    def _send(self) -> None:
        for publisher, payload in self._sent:
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


_LOG = logging.getLogger("hal.cameras")

FRAME_WAIT_S = 20.0
"""Lockstep: how long the world waits for a frame before its cameras count as dead."""


class FrameSource:
    """A camera owes a frame when ``(tick - episode_tick) % period_ticks == 0``.

    Lockstep: the frames of a tick go out before its joints, and again with each repeat.
    Realtime: they go out when they are ready, with the tick they show; a feed that is still
    busy skips a frame rather than falling behind.

    Attributes:
        failure: why no more frames come; "" while all is well.
    """

    def __init__(
        self,
        cameras: Sequence[HalCamera],
        feed: CameraFeed | None,
        publisher: TickPublisher,
        settings: HostSettings,
    ) -> None:
        self._cameras = tuple(cameras)
        self._feed = feed
        self._publisher = publisher
        self._session = settings.session
        self._lockstep = settings.lockstep
        self.failure = "" if feed or not cameras else "cameras off: no renderer was started"
        self._late: threading.Thread | None = None
        if feed is not None and not self._lockstep:
            self._late = threading.Thread(target=self._publish_late, name="cameras", daemon=True)
            self._late.start()

    @property
    def working(self) -> tuple[HalCamera, ...]:
        """The cameras whose frames can be expected."""
        return () if self.failure else self._cameras

    def send_due(self, tick: int, episode_tick: int, snapshot: Callable[[], bytes]) -> None:
        """Request the frames of ``tick``; in lockstep wait for them and publish them."""
        due = [
            camera.name
            for camera in self._cameras
            if (tick - episode_tick) % camera.period_ticks == 0
        ]
        if not due or self._feed is None or self.failure:
            return
        requested = self._feed.request(self._session, tick, due, snapshot())
        if self._lockstep and requested:
            self._publish_now(len(due))
        if self._feed.failure and not self.failure:
            self._fail(self._feed.failure)

    def close(self) -> None:
        """End the feed and the thread that waits for its late frames."""
        if self._feed is not None:
            self._feed.close()
            self._feed = None
        if self._late is not None:
            self._late.join(timeout=2.0)

    def _publish_now(self, count: int) -> None:
        assert self._feed is not None, "a frame was requested from it"
        for _ in range(count):
            image = self._feed.take(FRAME_WAIT_S)
            if image is None:
                self._fail(self._feed.failure or f"no frame within {FRAME_WAIT_S:g} s")
                return
            self._publisher.frame(image)

    def _publish_late(self) -> None:
        while (feed := self._feed) is not None and not feed.failure:
            image = feed.take(0.2)
            if image is not None:
                self._publisher.late_frame(image)

    def _fail(self, reason: str) -> None:
        self.failure = f"cameras off: {reason}"
        _LOG.error("%s", self.failure)
