"""Frames from one process to others of the same host and user, through memory that all of them see.

A sender listens on a Unix socket (abstract, so it has no file) and keeps slots of memory without a
name (`memfd`, so nothing is left in /dev/shm). A packet of a few bytes says which slot has the
frame; the reader looks at the slot itself and gives it back once nobody refers to the frame any
more. Nobody waits for anybody: a reader that gives nothing back, or takes nothing, is cut off, and
what it may still look at is never written again.
"""

from __future__ import annotations

import fcntl
import logging
import mmap
import os
import secrets
import select
import socket
import threading
from array import array
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from fairlead.messages import Bytes
from fairlead.wire.frame_link import BACK, FRAME, PACKET_MAX, address, is_own

HELD_MAX = 16
"""Frames that one reader may hold before it is cut off."""

_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
_BACKLOG = 16
_PAGE = 2**16

_LOG = logging.getLogger("frames")


@dataclass(eq=False)
class _Slot:
    number: int
    descriptor: int
    memory: mmap.mmap
    holders: set[_Reader] = field(default_factory=set)


@dataclass(eq=False)
class _Reader:
    link: socket.socket
    known: set[int] = field(default_factory=set)
    held: int = 0  # slots


class FrameSender:
    """The end that has frames. Any thread may send.

    Attributes:
        name: of its socket; who knows it and is of the same host and user may read.

    Raises:
        OSError: no socket could be made.
    """

    def __init__(self) -> None:
        self.name = secrets.token_hex(16)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.bind(address(self.name))
        self._socket.listen(_BACKLOG)
        self._socket.setblocking(False)
        self._lock = threading.Lock()
        self._heard = select.poll()  # one call of the kernel where nobody says anything
        self._heard.register(self._socket, select.POLLIN)
        self._readers: dict[int, _Reader] = {}  # by descriptor
        self._slots: dict[int, _Slot] = {}
        self._next = 1

    def send(self, parts: Sequence[Bytes]) -> int:
        """Give every reader one frame, the parts one after the other; says how many got it.

        Raises:
            OSError: no memory is left for it.
        """
        with self._lock:
            if not self._readers:
                self._hear()
            if not self._readers:
                return 0
            size = sum(map(len, parts))
            slot = self._free_slot(size)
            begin = 0
            for part in parts:
                slot.memory[begin : begin + len(part)] = part
                begin += len(part)
            told = [self._tell(reader, slot, size) for reader in list(self._readers.values())]
            self._hear()  # what takes time comes after the frame is on its way
            return sum(told)

    def close(self) -> None:
        """Let go of every reader."""
        with self._lock:
            if self._socket.fileno() >= 0:
                self._heard.unregister(self._socket)
            self._socket.close()
            for reader in list(self._readers.values()):
                self._cut_off(reader, "")
            for slot in list(self._slots.values()):
                self._forget(slot)

    def _hear(self) -> None:
        """Let new readers in, and take back what the others no more look at."""
        for descriptor, _ in self._heard.poll(0):
            reader = self._readers.get(descriptor)
            if reader is None:
                self._let_in()
            else:
                self._take_back(reader)
        for reader in list(self._readers.values()):
            if reader.held >= HELD_MAX:
                self._cut_off(reader, f"it holds {reader.held} frames")

    def _let_in(self) -> None:
        while True:
            try:
                link, _ = self._socket.accept()
            except OSError:  # nobody is there any more
                return
            if is_own(link):
                link.setblocking(False)
                self._readers[link.fileno()] = _Reader(link)
                self._heard.register(link, select.POLLIN)
            else:
                link.close()

    def _take_back(self, reader: _Reader) -> None:
        numbers = array(BACK)
        with suppress(OSError, ValueError):  # it is gone, or is no reader
            numbers.frombytes(reader.link.recv(PACKET_MAX))
        if not numbers:
            self._cut_off(reader, "")
        for number in numbers:
            slot = self._slots.get(number)
            if slot is not None and reader in slot.holders:
                slot.holders.remove(reader)
                reader.held -= 1

    def _free_slot(self, size: int) -> _Slot:
        for slot in self._slots.values():
            if not slot.holders and len(slot.memory) >= size:
                return slot
        for slot in [slot for slot in self._slots.values() if not slot.holders]:
            self._forget(slot)
        capacity = -(-max(size, 1) // _PAGE) * _PAGE
        descriptor = os.memfd_create("fairlead-frame", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.posix_fallocate(descriptor, 0, capacity)  # else a lack of memory would be a signal
            fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, _SEALS)
            memory = mmap.mmap(descriptor, capacity)
        except OSError:
            os.close(descriptor)
            raise
        slot = self._slots[self._next] = _Slot(self._next, descriptor, memory)
        self._next += 1
        return slot

    def _tell(self, reader: _Reader, slot: _Slot, size: int) -> bool:
        packet = FRAME.pack(slot.number, size)
        try:
            if slot.number in reader.known:
                reader.link.send(packet)
            else:
                there = array("I", self._slots).tobytes()
                socket.send_fds(reader.link, [packet, there], [slot.descriptor])
                reader.known = (reader.known & self._slots.keys()) | {slot.number}
        except OSError as error:
            gone = isinstance(error, BrokenPipeError | ConnectionResetError)
            self._cut_off(reader, "" if gone else f"it takes no frames: {error.strerror}")
            return False
        slot.holders.add(reader)
        reader.held += 1
        return True

    def _cut_off(self, reader: _Reader, why: str) -> None:
        """What it may still look at is forgotten, not used again."""
        del self._readers[reader.link.fileno()]
        self._heard.unregister(reader.link)
        reader.link.close()
        for slot in [slot for slot in self._slots.values() if reader in slot.holders]:
            self._forget(slot)
        if why:
            _LOG.warning("a reader of this host is cut off: %s", why)

    def _forget(self, slot: _Slot) -> None:
        for reader in slot.holders:
            reader.held -= 1  # of what it gives back nobody would know
        del self._slots[slot.number]
        os.close(slot.descriptor)
