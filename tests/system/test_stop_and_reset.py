"""A stop that was reset is over everywhere: gate, HAL and bus agree, before anybody arms again."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from bench.equipment.light_hal import Pacing
from bench.equipment.live_robot import wait_for
from fairlead.deploy.registry import Registry
from fairlead.errors import FairleadError
from fairlead.messages import GateState, HalStatus, JointState, StopLevel, decode
from fairlead.operate.client import RobotClient
from fairlead.wire.bus import Qos, Sample
from fairlead_tools.supervisor.scratch import Scratch, scratch_robot

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

AFTER_TICKS = 10


class Ear:
    """Ticks, stops and the HAL's states, in the order in which they came."""

    def __init__(self, client: RobotClient) -> None:
        self.heard: list[JointState | StopLevel | HalStatus] = []
        keys = client.keys
        for key, kind in ((keys.joints, JointState), (keys.stop, StopLevel),
                          (keys.hal_status, HalStatus)):  # fmt: skip
            client.bus.subscribe(key, self._taking(kind))

    def _taking(self, kind: type[JointState | StopLevel | HalStatus]) -> Callable[[Sample], None]:
        return lambda sample: self.heard.append(decode(kind, sample.payload))

    def ticks(self, since: int) -> int:
        return sum(isinstance(message, JointState) for message in self.heard[since:])


@pytest.mark.parametrize("pacing", ["realtime", "lockstep"])
def test_a_stop_that_was_reset_is_over_everywhere_at_once(
    light_scratch: Callable[[Pacing], Scratch], tmp_path: Path, pacing: Pacing
) -> None:
    with scratch_robot(light_scratch(pacing), Registry(tmp_path / "registry")) as robot:
        client, ear = robot.client, Ear(robot.client)
        client.arm()
        stop_id = client.stop("a test")
        wait_for(lambda: client.hal_status().state == "holding", "the HAL holds")
        before = dict(client.gate_status().counters)["stops_ignored"]
        client.reset(stop_id)
        since = len(ear.heard)
        wait_for(lambda: ear.ticks(since) >= AFTER_TICKS, "some ticks, or repeats of one")
        heard = ear.heard[since:]
        assert not [message for message in heard if isinstance(message, StopLevel)][2:]
        gate, hal = client.gate_status(), client.hal_status()
        assert (gate.state, gate.stop_ids) == (GateState.DISARMED, ())
        assert (hal.state, hal.detail) == ("ready", "")
        assert dict(gate.counters)["stops_ignored"] <= before + 2
        client.arm()


def test_thousands_of_stops_leave_the_hal_its_pace_and_an_operator_his_way_back(
    light_scratch: Callable[[Pacing], Scratch], tmp_path: Path
) -> None:
    with scratch_robot(light_scratch("realtime"), Registry(tmp_path / "registry")) as robot:
        client, ear = robot.client, Ear(robot.client)
        publisher = client.bus.publisher(client.keys.stop, StopLevel, Qos.HOT)
        for stop_id in range(1, 2001):
            publisher.put(StopLevel(stop_id=stop_id, by="attack", reason="one of many"))
            if stop_id % 50 == 0:
                threading.Event().wait(0.01)  # hot messages are dropped where nobody reads
        wait_for(lambda: client.gate_status().state == GateState.STOPPED, "the gate stops")
        since = len(ear.heard)
        wait_for(lambda: ear.ticks(since) >= 2 * AFTER_TICKS, "ticks go on")
        heard = ear.heard[since:]
        repeats = sum(isinstance(message, StopLevel) for message in heard)
        assert repeats / ear.ticks(since) < 40, "stops repeated in a tick"

        def acknowledged() -> bool:
            for one in client.gate_status().stop_ids:
                try:
                    client.reset(one)
                except FairleadError:  # it latched, or another copy came
                    continue
            return client.hal_status().state == "ready"  # those it holds go to the gate in turn

        wait_for(acknowledged, "every stop is reset")
