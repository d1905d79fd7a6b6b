"""A camera's frames over real sessions: through shared memory where it can be, never lost."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from fairlead.keys import Keys
from fairlead.messages import Image, decode
from fairlead.wire.bus import Publisher, Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.frame_route import FramePublisher
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

pytestmark = pytest.mark.processes

KEY = Keys("eyes").camera("front")
WAIT_S = 20.0


def image(tick: int) -> Image:
    return Image(
        session=1, tick=tick, camera="front", width=100, height=100, encoding_name="rgb8",
        data=bytes([tick % 251]) * 30_000,
    )  # fmt: skip


class Eyes:
    """Frames that came, and which way."""

    def __init__(self) -> None:
        self.got: list[tuple[int, bool]] = []
        self.came = threading.Condition()

    def on_sample(self, sample: Sample) -> None:
        found = decode(Image, sample.payload)
        assert found == image(found.tick)
        with self.came:
            self.got.append((found.tick, isinstance(sample.payload, memoryview)))
            self.came.notify_all()

    def is_shared(self) -> bool:
        return bool(self.got) and self.got[-1][1]


@pytest.fixture
def buses() -> Iterator[list[ZenohBus]]:
    """Two peers, the second of which listens to what the first sends."""
    first, second = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    made = [ZenohBus(Endpoints(listen=[first])), ZenohBus(Endpoints([second], [first]))]
    yield made
    for bus in made:
        bus.close()


def send_until(publisher: Publisher, eyes: Eyes, done: Callable[[], bool], tick: int) -> int:
    """Frames from ``tick`` on until something is so; the next tick."""
    for _ in range(int(WAIT_S / 0.02)):
        publisher.put(image(tick))
        tick += 1
        with eyes.came:
            if eyes.came.wait_for(done, 0.02):
                return tick
    raise AssertionError(f"it never was; last {eyes.got[-5:]}")


def test_frames_come_ordinarily_until_they_come_through_shared_memory_and_once_then(
    buses: list[ZenohBus],
) -> None:
    eyes = Eyes()
    buses[1].subscribe_frames(KEY, eyes.on_sample)
    publisher = buses[0].publisher(KEY, Image, Qos.CAMERA)
    assert isinstance(publisher, FramePublisher)
    tick = send_until(publisher, eyes, eyes.is_shared, 1)
    tick = send_until(publisher, eyes, lambda: not publisher._wanted(), tick)
    for after in range(tick, tick + 20):
        publisher.put(image(after))
        with eyes.came:
            assert eyes.came.wait_for(partial(eyes.got.__contains__, (after, True)), WAIT_S)
    late = [one for one in eyes.got if one[0] >= tick]
    assert late == [(after, True) for after in range(tick, tick + 20)], "each of them once"


def test_whoever_knows_nothing_of_it_gets_the_same_frames(buses: list[ZenohBus]) -> None:
    near, far = Eyes(), Eyes()
    buses[1].subscribe_frames(KEY, near.on_sample)
    buses[1].subscribe(KEY, far.on_sample)
    publisher = buses[0].publisher(KEY, Image, Qos.CAMERA)
    tick = send_until(publisher, near, near.is_shared, 1)
    tick = send_until(publisher, far, lambda: bool(far.got) and far.got[-1][0] > 1, tick)
    assert not any(shared for _, shared in far.got)


def test_without_memory_frames_come_the_ordinary_way_again(
    buses: list[ZenohBus], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    eyes = Eyes()
    buses[1].subscribe_frames(KEY, eyes.on_sample)
    publisher = buses[0].publisher(KEY, Image, Qos.CAMERA)
    assert isinstance(publisher, FramePublisher) and publisher._sender is not None
    tick = send_until(publisher, eyes, eyes.is_shared, 1)

    def full(size: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(publisher._sender, "_free_slot", full)
    tick = send_until(publisher, eyes, lambda: not eyes.is_shared(), tick)
    assert f"{KEY}: no shared memory, frames go the ordinary way" in caplog.text
    send_until(
        publisher, eyes, lambda: any(n >= tick and not shared for n, shared in eyes.got), tick
    )


def test_a_camera_that_comes_back_is_seen_again(buses: list[ZenohBus]) -> None:
    eyes = Eyes()
    buses[1].subscribe_frames(KEY, eyes.on_sample)
    first = buses[0].publisher(KEY, Image, Qos.CAMERA)
    assert isinstance(first, FramePublisher) and first._sender is not None
    tick = send_until(first, eyes, eyes.is_shared, 1)
    first._sender.close()
    eyes.got.clear()
    second = buses[0].publisher(KEY, Image, Qos.CAMERA)
    send_until(second, eyes, eyes.is_shared, tick)


def test_a_reader_that_was_cut_off_and_goes_on_comes_back(buses: list[ZenohBus]) -> None:
    eyes = Eyes()
    buses[1].subscribe_frames(KEY, eyes.on_sample)
    publisher = buses[0].publisher(KEY, Image, Qos.CAMERA)
    assert isinstance(publisher, FramePublisher) and publisher._sender is not None
    tick = send_until(publisher, eyes, eyes.is_shared, 1)
    sender = publisher._sender
    sender._cut_off(next(iter(sender._readers.values())), "a test")
    eyes.got.clear()
    send_until(publisher, eyes, eyes.is_shared, tick)


def test_on_a_machine_that_has_none_everything_goes_the_ordinary_way(
    buses: list[ZenohBus], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*args: object) -> None:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(socket, "socket", none)
    publisher = buses[0].publisher(KEY, Image, Qos.CAMERA)
    monkeypatch.undo()
    eyes = Eyes()
    subscription = buses[1].subscribe_frames(KEY, eyes.on_sample)
    send_until(publisher, eyes, lambda: len(eyes.got) > 3, 1)
    assert not eyes.is_shared()
    subscription.undeclare()
