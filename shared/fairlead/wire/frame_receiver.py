"""The end of shared frames that wants them; `fairlead.wire.frame_sender` says how it works."""

from __future__ import annotations

import fcntl
import logging
import mmap
import os
import socket
import struct
import threading
import weakref
from array import array
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial

import numpy as np
import numpy.typing as npt

from fairlead.messages import Bytes
from fairlead.wire.frame_link import BACK, FRAME, PACKET_MAX, address, is_own
from fairlead.wire.frame_thread import FrameThread

KEPT_MAX = 8
"""Frames that a reader keeps where they are; of more it keeps copies."""

_CONTROL_MAX = socket.CMSG_LEN(4)  # a descriptor
_Pixels = npt.NDArray[np.uint8]

_LOG = logging.getLogger("frames")


class FrameReceiver:
    """The end that wants frames.

    Args:
        name: the sender's.
        frames: the thread that takes them.
        on_frame: gets each, as long as it wants; read-only.
        on_end: the sender is gone, or has cut this reader off.

    Raises:
        OSError: no such sender on this host, or not of this user.
    """

    def __init__(
        self,
        name: str,
        frames: FrameThread,
        on_frame: Callable[[Bytes], None],
        on_end: Callable[[], None],
    ) -> None:
        self._name, self._frames = name, frames
        self._on_frame, self._on_end = on_frame, on_end
        self._link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._link.setblocking(False)  # a sender that sends nothing lets nobody in
        try:
            self._link.connect(address(name))
            self._link.setblocking(True)
            if not is_own(self._link):
                raise PermissionError("the sender is another user's")
        except OSError:
            self._link.close()
            raise
        self._memory: dict[int, _Pixels] = {}
        self._held: dict[int, weakref.ref[_Pixels]] = {}
        self._let_go_of: deque[int] = deque()  # whoever lets go of a frame must not wait
        self._ended = threading.Event()
        frames.add(self)

    def close(self) -> None:
        """No more frames; those there are stay. Waits for the thread, unless called on it."""
        with suppress(OSError):  # the sender was faster
            self._link.shutdown(socket.SHUT_RDWR)
        if not self._frames.is_current:
            self._ended.wait()

    def fileno(self) -> int:
        """The link's descriptor."""
        return self._link.fileno()

    def take(self) -> bool:
        """Take a frame that has come; False if no more will."""
        try:
            return self._take_one()
        except (OSError, ValueError, struct.error) as error:
            _LOG.warning("not a frame: %s", error)
        except Exception:  # noqa: BLE001 - its reader's fault ends these frames, no others
            _LOG.exception("frames of %s end", self._name)
        return False

    def give_back(self) -> None:
        """Tell the sender what nobody looks at any more."""
        back = array(BACK)
        while self._let_go_of:
            back.append(self._let_go_of.popleft())
        if back:
            with suppress(OSError):  # there is no sender any more
                self._link.send(back, socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL)

    def end(self) -> None:
        """No more frames come."""
        self._link.close()
        try:
            self._on_end()
        except Exception:  # noqa: BLE001 - likewise
            _LOG.exception("after the frames of %s", self._name)
        finally:
            self._ended.set()

    def _take_one(self) -> bool:
        try:
            packet, control, _, _ = self._link.recvmsg(PACKET_MAX, _CONTROL_MAX)
        except ConnectionError:
            return False
        if not packet:
            return False
        number, size = FRAME.unpack_from(packet)
        if control:
            self._learn(number, packet, control[0][2])
        memory = self._memory.get(number)
        if memory is None or size > len(memory):
            raise ValueError(f"expected {size} bytes in slot {number}")
        frame = memory[:size]
        if len(self._held) >= KEPT_MAX:
            self._on_frame(_seen(frame.copy()))
            self._let_go_of.append(number)
        else:
            # Whatever is made of the frame refers to this array, so its end is theirs.
            self._held[number] = weakref.ref(frame, partial(self._let_go, number))
            self._on_frame(_seen(frame))
        return True

    def _learn(self, number: int, packet: bytes, descriptors: bytes) -> None:
        """Take a new slot, and forget those that are there no more."""
        there = set(memoryview(packet)[FRAME.size :].cast("I"))
        self._memory = {one: memory for one, memory in self._memory.items() if one in there}
        for descriptor in memoryview(descriptors).cast("i"):
            self._memory[number] = _mapped(descriptor)

    def _let_go(self, number: int, _: object) -> None:
        del self._held[number]
        self._let_go_of.append(number)


def _seen(frame: _Pixels) -> Bytes:
    seen: Bytes = memoryview(frame).toreadonly()  # type: ignore[assignment, arg-type]
    return seen


def _mapped(descriptor: int) -> _Pixels:
    """What a descriptor has, unless it could shrink while somebody looks at it.

    Raises:
        OSError, ValueError: it is not such memory.
    """
    try:
        if not fcntl.fcntl(descriptor, fcntl.F_GET_SEALS) & fcntl.F_SEAL_SHRINK:
            raise ValueError("memory that may shrink")
        return np.frombuffer(mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ), np.uint8)
    finally:
        os.close(descriptor)
