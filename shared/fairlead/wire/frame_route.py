"""A camera's frames by the shortest way: shared memory within a host, Zenoh to all others.

The key and the bytes are the same either way. A liveliness token beside the key names the socket
of `fairlead.wire.frame_sender`; who cannot reach it stays subscribed, as everybody is at first.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from typing import Protocol

from fairlead.keys import last_chunk
from fairlead.messages import Bytes, Image, Message, encode, encode_parts
from fairlead.wire.bus import Bus, Publisher, Sample, SampleHandler, Undeclare
from fairlead.wire.failures import dropping
from fairlead.wire.frame_receiver import FrameReceiver
from fairlead.wire.frame_sender import FrameSender
from fairlead.wire.frame_thread import FrameThread

_LOG = logging.getLogger("frames")
_SHARED = "shared"


class _Declares(Protocol):
    def declare_token(self, key: str) -> Undeclare: ...


class FramePublisher:
    """Gives frames to this host's readers, and to Zenoh if anybody is subscribed.

    Args:
        ordinary: sends them over Zenoh.
        wanted: whether anybody is subscribed there.
    """

    def __init__(
        self, bus: _Declares, key: str, ordinary: Publisher, wanted: Callable[[], bool]
    ) -> None:
        self._key, self._ordinary, self._wanted = key, ordinary, wanted
        self._sender: FrameSender | None = None
        try:
            self._sender = FrameSender()
            bus.declare_token(f"{key}/{_SHARED}/{self._sender.name}")
        except OSError as error:
            self._without(error)

    def put(self, message: Message) -> None:
        """Send a frame; an `Image` is not put together first."""
        self._put(encode_parts(message) if isinstance(message, Image) else (encode(message),))

    def put_bytes(self, payload: bytes) -> None:
        """Send an encoded frame."""
        self._put((payload,))

    def _put(self, parts: Sequence[Bytes]) -> None:
        if self._sender is not None:
            try:
                self._sender.send(parts)
            except OSError as error:
                self._without(error)
        if self._wanted():
            self._ordinary.put_bytes(b"".join(parts))

    def close(self) -> None:
        """No more frames through shared memory."""
        if self._sender is not None:
            self._sender.close()
            self._sender = None

    def _without(self, error: OSError) -> None:
        """Readers notice that the sender is gone, and subscribe again."""
        _LOG.warning("%s: no shared memory, frames go the ordinary way: %s", self._key, error)
        self.close()


class FrameSubscription:
    """Calls ``handler`` for each frame of a camera, on Zenoh's threads or on ``frames``."""

    def __init__(self, bus: Bus, key: str, handler: SampleHandler, frames: FrameThread) -> None:
        self._frames = frames
        self._bus, self._key, self._handler = bus, key, dropping(handler)
        self._lock = threading.Lock()
        self._receivers: dict[str, FrameReceiver] = {}
        self._sure: set[str] = set()  # those of them that have brought a frame
        self._is_over = False
        self._ordinary: Undeclare | None = bus.subscribe(key, handler)
        self._tokens = bus.watch_tokens(f"{key}/{_SHARED}/*", self._on_token)

    def undeclare(self) -> None:
        """The handler is called no more."""
        self.close()
        self._tokens.undeclare()
        with self._lock:
            ordinary, self._ordinary = self._ordinary, None
        if ordinary is not None:
            ordinary.undeclare()

    def close(self) -> None:
        """No more frames through shared memory."""
        with self._lock:
            self._is_over = True
            receivers = list(self._receivers.values())
        for one in receivers:
            one.close()

    def _on_token(self, token: str, alive: bool) -> None:
        if alive:
            self._connect(last_chunk(token))

    def _connect(self, name: str) -> None:
        with self._lock:
            if self._is_over or name in self._receivers:
                return
            try:
                self._receivers[name] = FrameReceiver(
                    name,
                    self._frames,
                    lambda frame: self._on_frame(name, frame),
                    lambda: self._on_end(name),
                )
            except OSError:  # the sender is on another host, or another user's
                return

    def _on_frame(self, name: str, frame: Bytes) -> None:
        """The first one shows that the shorter way works: the other is given up then."""
        if name not in self._sure:
            with self._lock:
                self._sure.add(name)
                ordinary, self._ordinary = self._ordinary, None
            if ordinary is not None:
                ordinary.undeclare()
                _LOG.info("%s: frames come through shared memory", self._key)
        self._handler(Sample(self._key, frame))

    def _on_end(self, name: str) -> None:
        """Frames come the ordinary way again, unless the sender is there and takes this reader."""
        with self._lock:
            del self._receivers[name]
            self._sure.discard(name)
            again = not self._is_over and self._ordinary is None and not self._sure
            if again:
                self._ordinary = self._bus.subscribe(self._key, self._handler)
        if again:
            _LOG.info("%s: frames come the ordinary way", self._key)
        self._connect(name)
