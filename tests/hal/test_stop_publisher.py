"""A stop of the HAL is said again until it is listed, at its pace however late it is asked."""

from __future__ import annotations

from fairlead.hal.core import HalCore
from fairlead.hal.identity import HostSettings
from fairlead.hal.inbox import SharedCore
from fairlead.hal.status_and_stops import StopPublisher
from fairlead.keys import Keys
from fairlead.messages import StopLevel, decode
from fairlead.wire.memory_bus import MemoryBus

MS = 1_000_000


def test_stops_keep_their_pace_when_they_are_asked_late() -> None:
    bus = MemoryBus()
    keys = Keys("some")
    heard: list[StopLevel] = []
    bus.subscribe(keys.stop, lambda sample: heard.append(decode(StopLevel, sample.payload)))
    core = SharedCore(HalCore(1, "realtime", 1, 1, 50 * MS))
    caller = StopPublisher(bus, HostSettings("hal", keys, "realtime", 1), core)

    caller.raise_stop("a test")
    said = []
    for now_ms in (1_000, 1_049, 1_064, 1_099, 1_113, 1_149, 1_312, 1_349, 1_350):
        before = len(heard)
        caller.repeat_due(now_ms * MS)
        said.append((now_ms, len(heard) - before))

    # Every 50 ms from 1,000 on: late by up to 14 ms, the next one is due 50 ms after the last was
    # due. After a pause of three periods it is said once, not three times.
    again = [now_ms for now_ms, count in said if count == 1]
    assert again == [1_000, 1_064, 1_113, 1_312, 1_350]
    assert {count for _, count in said} == {0, 1}
    assert len({stop.stop_id for stop in heard}) == 1
