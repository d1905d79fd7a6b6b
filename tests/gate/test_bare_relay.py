"""Bytes through the C++ side of Zenoh and back: every length arrives whole."""

from __future__ import annotations

import queue
import subprocess
from collections.abc import Iterator

import numpy as np
import pytest

from bench.equipment.mailbox import DEADLINE_S
from fairlead.messages import Image
from fairlead.paths import gate_binary
from fairlead.wire.bus import Publisher, Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

pytestmark = pytest.mark.processes

KEY_IN, KEY_OUT = "fl/test/relay_in", "fl/test/relay_out"
RESEND_S = 0.1


@pytest.fixture
def relay_bus() -> Iterator[ZenohBus]:
    """A session connected to a running bare-relay."""
    endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    words = [str(gate_binary().with_name("bare-relay")), endpoint, KEY_IN, KEY_OUT]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as relay:
        assert relay.stdout is not None
        assert relay.stdout.readline() == "ready\n"
        bus = ZenohBus(Endpoints(connect=[endpoint]))
        yield bus
        bus.close()
        relay.terminate()
        assert relay.wait(DEADLINE_S) == 0


@pytest.mark.parametrize("size", [0, 1, 500, 65_000, 65_536])
def test_a_payload_comes_back_as_it_was_sent(relay_bus: ZenohBus, size: int) -> None:
    # The longest ones travel in fragments and arrive as several pieces of memory.
    payload = np.random.default_rng(size).bytes(size)
    received: queue.Queue[bytes] = queue.Queue()
    relay_bus.subscribe(KEY_OUT, lambda sample: received.put(sample.payload))
    publisher = relay_bus.publisher(KEY_IN, Image, Qos.HOT)
    assert sent_until_received(publisher, payload, received) == payload


def sent_until_received(
    publisher: Publisher, payload: bytes, received: queue.Queue[bytes]
) -> bytes:
    """Send again until something comes back: the link may not be up at the first time."""
    for _ in range(int(DEADLINE_S / RESEND_S)):
        publisher.put_bytes(payload)
        try:
            return received.get(timeout=RESEND_S)
        except queue.Empty:
            continue
    raise AssertionError(f"nothing came back within {DEADLINE_S} s")
