"""Two ends of a transport, in both of its forms."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from fairlead.wire.endpoints import Endpoints
from fairlead.wire.memory_bus import MemoryBus
from fairlead.wire.session import ZenohBus
from tests.wire.pair import Pair, free_endpoint


@pytest.fixture(params=["memory", "zenoh"])
def pair(request: pytest.FixtureRequest) -> Iterator[Pair]:
    if request.param == "memory":
        bus = MemoryBus()
        yield Pair(bus, bus)
        return
    endpoint = free_endpoint()
    near = ZenohBus(Endpoints(listen=[endpoint]))
    far = ZenohBus(Endpoints(connect=[endpoint]))
    both = Pair(near, far)
    both.settle()
    yield both
    far.close()
    near.close()
