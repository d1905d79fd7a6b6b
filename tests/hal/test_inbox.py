"""What the HAL says of messages that it does not take."""

from __future__ import annotations

import logging
from typing import cast

import msgspec
import numpy as np
import pytest

from fairlead.hal.backend import Measurement
from fairlead.hal.core import HalCore
from fairlead.hal.identity import HostSettings
from fairlead.hal.inbox import HalInbox, SharedCore
from fairlead.hal.lease_follower import LeaseFollower
from fairlead.hal.tick_publisher import TickPublisher
from fairlead.keys import Keys
from fairlead.messages import JointState, Lease, decode, encode
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.memory_bus import MemoryBus
from tests.hal.gate_messages import SESSION, lease

KEYS = Keys("r")


class LeaseCore:
    """The part of a core that takes leases."""

    def __init__(self) -> None:
        self._leases = LeaseFollower(SESSION)

    def on_lease(self, message: Lease, now_ns: int) -> str:
        return self._leases.offer(message, now_ns)


def test_a_lease_of_the_last_session_is_a_second_gates_only_after_one_of_this_session(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO, "hal.inbox")
    bus = MemoryBus()
    core = cast("HalCore", LeaseCore())
    HalInbox(SharedCore(core), bus, KEYS, lambda: 0, lambda payload: True)
    leases = bus.publisher(KEYS.lease, Lease, Qos.HOT)
    foreign, started = (lease(1, 1, session=session) for session in (SESSION + 1, 0))
    for message in (foreign, started, lease(1, 1), started, foreign, foreign):
        leases.put(message)
    said = [(record.levelname, record.message) for record in caplog.records]
    assert said == [("WARNING", f"{KEYS.lease}: ignored: lease of a second live gate")]


def test_a_joint_state_that_somebody_else_sends_in_the_hals_name_stops_the_robot() -> None:
    bus, core = MemoryBus(), HalCore(SESSION, "realtime", 4, 11, 50_000_000)
    ticks = TickPublisher(bus, HostSettings("hal", KEYS, "realtime", SESSION), ())
    HalInbox(SharedCore(core), bus, KEYS, lambda: 0, ticks.is_own)
    heard: list[Sample] = []
    bus.subscribe(KEYS.joints, heard.append)
    at_rest = Measurement(np.zeros(14), np.zeros(14), np.zeros(14))
    ticks.finish(5, 1, 0, at_rest, core.acted, bytes(32), None)
    ticks.repeat(0)
    own = decode(JointState, heard[0].payload)
    bus.deliver(Sample(KEYS.joints, encode(msgspec.structs.replace(own, session=SESSION + 1))))
    bus.deliver(Sample(KEYS.joints, b"junk"))
    assert (len(heard), core.demanded_stops) == (4, ())

    bus.deliver(Sample(KEYS.joints, encode(msgspec.structs.replace(own, tick=6))))
    said = "somebody else sends this session's joint states, tick 6"
    assert core.demanded_stops == (("two HALs", said),)
