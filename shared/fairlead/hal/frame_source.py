"""Asks the camera feed for the frames a tick owes, and publishes them."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence

from fairlead.hal.camera_feed import CameraFeed
from fairlead.hal.host_settings import HostSettings
from fairlead.hal.tick_publisher import TickPublisher
from fairlead.messages import HalCamera

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
            self._late = threading.Thread(target=self._publish_late, name="frames", daemon=True)
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
