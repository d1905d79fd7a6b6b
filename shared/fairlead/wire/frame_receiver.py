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
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from fairlead.messages import Bytes
from fairlead.wire.frame_link import BACK, FRAME, PACKET_MAX, address, is_own

KEPT_MAX = 8
"""Frames that a reader keeps where they are; of more it keeps copies."""

_LOG = logging.getLogger("frames")


class FrameReceiver:
    """The end that wants frames, on a thread of its own.

    Args:
        name: the sender's.
        thread: what the thread is called.
        on_frame: gets each, as long as it wants; read-only.
        on_end: the sender is gone, or has cut this reader off.

    Raises:
        OSError: no such sender on this host, or not of this user.
    """

    def __init__(
        self,
        name: str,
        thread: str,
        on_frame: Callable[[Bytes], None],
        on_end: Callable[[], None],
    ) -> None:
        self._on_frame, self._on_end = on_frame, on_end
        self._link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._link.connect(address(name))
            if not is_own(self._link):
                raise PermissionError("the sender is another user's")
        except OSError:
            self._link.close()
            raise
        self._memory: dict[int, mmap.mmap] = {}
        self._held: set[int] = set()
        self._thread = threading.Thread(target=self._run, name=thread, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """No more frames; those there are stay. Waits for the thread, unless called on it."""
        with suppress(OSError):  # the sender was faster
            self._link.shutdown(socket.SHUT_RDWR)
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        try:
            while self._take_one():
                pass
        except (OSError, ValueError, struct.error) as error:
            _LOG.warning("not a frame: %s", error)
        finally:
            self._link.close()
            self._on_end()

    def _take_one(self) -> bool:
        try:
            packet, descriptors, _, _ = socket.recv_fds(self._link, PACKET_MAX, 1)
        except ConnectionError:
            return False
        if not packet:
            return False
        number, size = FRAME.unpack_from(packet)
        for descriptor in descriptors:
            self._memory[number] = _mapped(descriptor)
        memory = self._memory.get(number)
        if memory is None or size > len(memory):
            raise ValueError(f"expected {size} bytes in slot {number}")
        # Whatever is made of the frame refers to this array, so its end is theirs.
        frame: Any = np.frombuffer(memory, np.uint8, size)
        if len(self._held) >= KEPT_MAX:
            self._on_frame(_seen(frame.copy()))
            self._give_back(number)
        else:
            self._held.add(number)
            weakref.finalize(frame, self._let_go, number).atexit = False
            self._on_frame(_seen(frame))
        if descriptors:  # so some may be there no more
            there = set(memoryview(packet)[FRAME.size :].cast("I"))
            self._memory = {one: memory for one, memory in self._memory.items() if one in there}
        return True

    def _let_go(self, number: int) -> None:
        self._held.discard(number)
        self._give_back(number)

    def _give_back(self, number: int) -> None:
        with suppress(OSError):  # there is no sender any more
            self._link.send(BACK.pack(number), socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL)


def _seen(frame: Any) -> Bytes:
    frame.flags.writeable = False
    seen: Bytes = memoryview(frame)  # type: ignore[assignment]
    return seen


def _mapped(descriptor: int) -> mmap.mmap:
    """What a descriptor has, unless it could shrink while somebody looks at it.

    Raises:
        OSError, ValueError: it is not such memory.
    """
    try:
        if not fcntl.fcntl(descriptor, fcntl.F_GET_SEALS) & fcntl.F_SEAL_SHRINK:
            raise ValueError("memory that may shrink")
        return mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
    finally:
        os.close(descriptor)
