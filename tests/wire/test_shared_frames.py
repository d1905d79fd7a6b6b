"""Frames through shared memory: whole, never overwritten while somebody looks, never in the way."""

from __future__ import annotations

import gc
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from queue import SimpleQueue
from typing import Any

import numpy as np
import pytest

from fairlead.messages import Bytes, Image, decode, encode, encode_parts
from fairlead.wire import frame_receiver
from fairlead.wire.frame_link import address
from fairlead.wire.frame_receiver import KEPT_MAX, FrameReceiver
from fairlead.wire.frame_sender import HELD_MAX, FrameSender
from fairlead.wire.frame_thread import FrameThread

WAIT_S = 10.0
READER = """
import sys, time
from fairlead.wire.frame_receiver import FrameReceiver
from fairlead.wire.frame_thread import FrameThread
kept = []
def on_frame(frame):
    kept.append(frame)
    print(len(frame), flush=True)
FrameReceiver(sys.argv[1], FrameThread(), on_frame, lambda: print("end", flush=True))
sys.stdin.read()
"""


class Reader:
    """A receiver in this process, and what it was given."""

    def __init__(self, name: str, thread: FrameThread | None = None) -> None:
        self.frames: SimpleQueue[Bytes] = SimpleQueue()
        self.ended = threading.Event()
        self.receiver = FrameReceiver(name, thread or FrameThread(), self.take, self.ended.set)

    def take(self, frame: Bytes) -> None:
        self.frames.put(frame)

    def next(self) -> Bytes:
        return self.frames.get(timeout=WAIT_S)


@pytest.fixture
def sender() -> Iterator[FrameSender]:
    made = FrameSender()
    yield made
    made.close()


def frame(number: int, size: int = 1000) -> bytes:
    return np.random.default_rng(number).bytes(size)


def sent_until(sender: FrameSender, done: Callable[[], bool], first: int = 0) -> int:
    """Send frames until something is so; the number of the last."""
    until = threading.Event()
    for number in range(first, first + 10_000):
        sender.send([frame(number)])
        if done():
            return number
        until.wait(0.01)
    raise AssertionError("it never was")


def test_a_frame_is_the_parts_one_after_the_other_and_each_reader_gets_it(
    sender: FrameSender,
) -> None:
    assert sender.send([b"nobody"]) == 0
    readers = [Reader(sender.name), Reader(sender.name)]
    assert sender.send([b"head", b"pixels"]) == 2
    for reader in readers:
        got = reader.next()
        assert bytes(got) == b"headpixels" and memoryview(got).readonly
    sender.close()
    assert all(reader.ended.wait(WAIT_S) for reader in readers)


class Clumsy(Reader):
    """Fails at each frame."""

    def take(self, frame: Bytes) -> None:
        raise RuntimeError("clumsy")


def test_the_frames_of_all_cameras_come_on_one_thread_and_one_s_fault_is_its_own(
    caplog: pytest.LogCaptureFixture,
) -> None:
    thread = FrameThread()
    senders = [FrameSender() for _ in range(3)]
    kinds = (Reader, Clumsy, Reader)
    readers = [kind(one.name, thread) for kind, one in zip(kinds, senders, strict=True)]
    before = thread._thread
    for number in range(2 * KEPT_MAX):
        told = [one.send([frame(number)]) for one in senders]
        assert told[::2] == [1, 1]
        assert [bytes(one.next()) for one in readers[::2]] == [frame(number)] * 2
    assert readers[1].ended.wait(WAIT_S) and "RuntimeError: clumsy" in caplog.text
    assert thread._thread is before
    for one in readers:
        one.receiver.close()
    assert before is not None
    before.join(WAIT_S)
    assert not before.is_alive(), "it ends with the last of them"
    again = Reader(senders[0].name, thread)
    sent_until(senders[0], lambda: not again.frames.empty())
    for sender in senders:
        sender.close()
    assert again.ended.wait(WAIT_S)


def given_back(sender: FrameSender) -> None:
    """Wait until one slot is held at most: a reader gives back once the next frame has come."""
    until = threading.Event()
    for _ in range(int(WAIT_S / 0.001)):
        with sender._lock:
            sender._hear()
        if sum(bool(slot.holders) for slot in sender._slots.values()) <= 1:
            return
        until.wait(0.001)
    raise AssertionError("a slot was never given back")


def test_what_is_kept_is_never_overwritten(sender: FrameSender) -> None:
    reader = Reader(sender.name)
    kept = []
    for number in range(3 * HELD_MAX):
        sender.send([frame(number)])
        kept.append(reader.next())
    assert not reader.ended.is_set(), "of more than it may hold it keeps copies"
    assert [bytes(one) for one in kept] == [frame(number) for number in range(3 * HELD_MAX)]
    assert len(sender._slots) <= HELD_MAX


def test_a_view_of_a_view_keeps_the_frame_too(sender: FrameSender) -> None:
    reader = Reader(sender.name)
    image = Image(
        session=1, tick=1, camera="front", width=20, height=10, encoding_name="rgb8",
        data=frame(0, 600),
    )  # fmt: skip
    sender.send(encode_parts(image))
    pixels = np.frombuffer(decode(Image, reader.next()).data, np.uint8).reshape(10, 20, 3)[2:]
    gc.collect()
    for number in range(1, 50):
        sender.send([frame(number)])
        reader.next()
    np.testing.assert_array_equal(pixels.reshape(-1), np.frombuffer(image.data, np.uint8)[120:])


def test_memory_is_used_again_once_nobody_looks_at_it(sender: FrameSender) -> None:
    reader = Reader(sender.name)
    for number in range(200):
        sender.send([frame(number, 900 + number)])
        assert bytes(reader.next()) == frame(number, 900 + number)
    assert len(sender._slots) < KEPT_MAX


def test_a_larger_frame_takes_the_place_of_what_is_too_small(sender: FrameSender) -> None:
    reader = Reader(sender.name)
    for number, size in enumerate((10, 70_000, 200_000, 10, 300_000)):
        sender.send([frame(number, size)])
        assert bytes(reader.next()) == frame(number, size)
        given_back(sender)
    assert len(sender._slots) <= 2, "those nobody looks at are gone"
    assert len(reader.receiver._memory) <= 2


@pytest.mark.processes
@pytest.mark.parametrize("hurt", [signal.SIGKILL, signal.SIGSTOP])
def test_a_reader_that_is_killed_or_hangs_is_no_hindrance_to_the_others(
    sender: FrameSender, hurt: signal.Signals
) -> None:
    mine = Reader(sender.name)
    with subprocess.Popen(
        [sys.executable, "-c", READER, sender.name],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as other:  # fmt: skip
        assert other.stdout is not None
        lines: SimpleQueue[str] = SimpleQueue()
        stream = other.stdout

        def listen() -> None:
            for line in stream:
                lines.put(line)

        threading.Thread(target=listen, daemon=True).start()
        first = sent_until(sender, lambda: not lines.empty())
        os.kill(other.pid, hurt)
        last = sent_until(sender, lambda: len(sender._readers) == 1, first + 1)
        got = [bytes(mine.next()) for _ in range(last + 1)]
        assert got == [frame(number) for number in range(last + 1)]
        os.kill(other.pid, signal.SIGCONT if hurt == signal.SIGSTOP else 0)
        if hurt == signal.SIGSTOP:
            while lines.get(timeout=WAIT_S) != "end\n":
                pass  # what it was told before; it then knows
        other.kill()


def test_readers_that_come_and_go_are_none_of_another_ones_fault(sender: FrameSender) -> None:
    """Both keep what they get; what the one that leaves held is forgotten, for the other, too."""
    stays = Reader(sender.name)
    kept: list[Bytes] = []
    for round_number in range(10):
        other = Reader(sender.name)
        sender.send([frame(0)])  # after which it is let in
        stays.next()
        both: list[Bytes] = []
        for number in range(4):
            sender.send([frame(10 * round_number + number)])
            both += [stays.next(), other.next()]
        kept = [*kept[-2:], *both[::2]]
        other.receiver.close()
        del both
        gc.collect()
    assert not stays.ended.is_set()
    assert max(reader.held for reader in sender._readers.values()) < HELD_MAX // 2


def test_a_sender_that_lets_nobody_in_keeps_nobody_waiting(sender: FrameSender) -> None:
    waiting = []
    with pytest.raises(OSError, match=r"."):  # a HAL whose renderer did not start
        for _ in range(100):
            waiting.append(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
            waiting[-1].setblocking(False)
            waiting[-1].connect(address(sender.name))
    with pytest.raises(OSError, match=r"."):
        Reader(sender.name)
    for link in waiting:
        link.close()


def test_without_memory_the_sender_says_so(
    sender: FrameSender, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader = Reader(sender.name)

    def full(*args: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(OSError, match="No space left"):
        sender.send([frame(1)])
    assert not sender._slots
    assert reader.frames.empty()


def test_memory_that_may_shrink_is_not_looked_at() -> None:
    descriptor = os.memfd_create("test")
    os.truncate(descriptor, 4096)
    with pytest.raises(OSError, match="Invalid argument|not permitted|may shrink"):
        try:
            frame_receiver._mapped(descriptor)
        except ValueError as error:
            raise OSError(str(error)) from None


def test_there_is_no_sender_of_another_name() -> None:
    with pytest.raises(ConnectionRefusedError):
        Reader("nobody")


@pytest.mark.parametrize("size", [0, 1, 255, 256, 65535, 65536, 300_000])
def test_an_image_in_two_parts_has_the_bytes_of_the_whole(size: int) -> None:
    image = Image(
        session=7, tick=300, camera="front", width=9, height=9, encoding_name="jpeg",
        data=frame(3, size),
    )  # fmt: skip
    assert b"".join(encode_parts(image)) == encode(image)
    assert decode(Image, encode(image)) == image
