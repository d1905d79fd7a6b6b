"""The ways a picture takes: each has one end that sends and one that receives."""

from __future__ import annotations

import mmap
import multiprocessing
import os
import threading
from collections.abc import Callable
from contextlib import closing
from typing import Any

import numpy as np

from bench.image_move.pictures import (
    FIRST_S,
    HZ,
    PATIENCE_S,
    WARM_UP,
    Arrivals,
    Case,
    Pixels,
    ticks,
)
from fairlead.keys import Keys
from fairlead.messages import Image, decode
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

KEYS = Keys("bench")
_SLOTS = 32
"""So many that a late reader loses nothing."""


def floor(case: Case, count: int) -> list[float]:
    """A ring of shared memory and an eventfd: one copy in, none out, and nobody else's fault."""
    ring = mmap.mmap(-1, _SLOTS * case.cameras * case.size)
    slots = np.frombuffer(ring, np.uint8).reshape(-1, case.height, case.width, 3)
    bell = os.eventfd(0, os.EFD_SEMAPHORE)

    def send() -> None:
        for tick, pictures in enumerate(ticks(case, count)):
            for camera, one in enumerate(pictures):
                slots[(tick * case.cameras + camera) % len(slots)] = one
                os.eventfd_write(bell, 1)

    def receive() -> list[float]:
        arrivals, index = Arrivals(case, count), 0
        while os.eventfd_read(bell) and not arrivals.add(slots[index % len(slots)]):
            index += 1
        return arrivals.latencies_us

    try:
        return _both(send, receive)
    finally:
        os.close(bell)


def fairlead(case: Case, count: int) -> list[float]:
    """As a HAL sends and a runner receives on one host."""
    return _over_bus(case, count, shared=True)


def zenoh(case: Case, count: int) -> list[float]:
    """As between hosts: Zenoh over TCP."""
    return _over_bus(case, count, shared=False)


def _over_bus(case: Case, count: int, *, shared: bool) -> list[float]:
    ends = [f"tcp/127.0.0.1:{port}" for port in free_ports(2)]

    def send() -> None:
        with closing(ZenohBus(Endpoints(listen=ends[1:], connect=ends[:1]))) as bus:
            cameras = [
                (str(number), bus.publisher(KEYS.camera(str(number)), Image, Qos.CAMERA))
                for number in range(case.cameras)
            ]
            for tick, pictures in enumerate(ticks(case, count), start=1):
                for (name, publisher), one in zip(cameras, pictures, strict=True):
                    publisher.put(_message(tick, name, one))
            received.wait(PATIENCE_S)

    def receive() -> list[float]:
        with closing(ZenohBus(Endpoints(listen=ends[:1]))) as bus:
            arrivals, done, ordinary = Arrivals(case, count), threading.Event(), [0]

            def on_sample(sample: Sample) -> None:
                ordinary[0] += not isinstance(sample.payload, memoryview)
                image = decode(Image, sample.payload)
                pixels = np.frombuffer(image.data, np.uint8)
                if arrivals.add(pixels.reshape(image.height, image.width, 3)):
                    done.set()

            for number in range(case.cameras):
                key = KEYS.camera(str(number))
                (bus.subscribe_frames if shared else bus.subscribe)(key, on_sample)
            done.wait(FIRST_S + count / HZ + PATIENCE_S)
            received.set()
            if shared and ordinary[0] > WARM_UP * case.cameras:
                raise SystemExit(f"bench.image_move: {ordinary[0]} pictures came the ordinary way")
            return arrivals.latencies_us

    received = multiprocessing.get_context("fork").Event()
    return _both(send, receive)


def _message(tick: int, camera: str, pixels: Pixels) -> Image:
    data: Any = pixels.reshape(-1).data
    return Image(
        session=1, tick=tick, camera=camera, width=pixels.shape[1], height=pixels.shape[0],
        encoding_name="rgb8", data=data,
    )  # fmt: skip


def _both(send: Callable[[], None], receive: Callable[[], list[float]]) -> list[float]:
    """Each end in a process of its own; what the receiver returns."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    receiver = context.Process(target=lambda: theirs.send(receive()))
    sender = context.Process(target=send)
    receiver.start()
    sender.start()
    theirs.close()
    try:
        found: list[float] = ours.recv()
    except EOFError:
        raise SystemExit("bench.image_move: the receiver failed; see above") from None
    finally:
        sender.join(PATIENCE_S)
        for one in (sender, receiver):
            one.kill()
            one.join()
    return found
