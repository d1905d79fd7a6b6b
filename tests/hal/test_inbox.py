"""What the HAL says of messages that it does not take."""

from __future__ import annotations

import logging
from threading import Condition
from typing import cast

import pytest

from fairlead.hal.core import HalCore
from fairlead.hal.inbox import HalInbox
from fairlead.hal.lease_follower import LeaseFollower
from fairlead.keys import Keys
from fairlead.messages import Lease
from fairlead.wire.bus import Qos
from fairlead.wire.memory_bus import MemoryBus
from tests.hal.gate_messages import SESSION, lease

KEYS = Keys("r")


class LeaseCore:
    """The part of a core that takes leases."""

    def __init__(self) -> None:
        self._leases = LeaseFollower(SESSION)

    @property
    def gate_state(self) -> int | None:
        return self._leases.state

    def on_lease(self, message: Lease, now_ns: int) -> str:
        return self._leases.offer(message, now_ns)


def test_a_lease_of_the_last_session_is_a_warning_only_after_one_of_this_session(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO, "hal.inbox")
    bus = MemoryBus()
    HalInbox(cast("HalCore", LeaseCore()), bus, KEYS, Condition(), lambda: 0)
    leases = bus.publisher(KEYS.lease, Lease, Qos.HOT)
    foreign = lease(1, 1, session=SESSION + 1)
    for message in (foreign, foreign, lease(1, 1), foreign, foreign):
        leases.put(message)
    text = f"{KEYS.lease}: ignored: lease of another session"
    said = [(record.levelname, record.message) for record in caplog.records]
    assert said == [("INFO", text), ("WARNING", text)]
