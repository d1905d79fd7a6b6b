"""A reset that takes long: the gate is told before, and rows of the old episode never act."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import pytest

from fairlead.errors import ConfigError, RefusedError
from fairlead.hal import episode_reset
from fairlead.hal.core import HalCore, Pacing, TickPlan
from fairlead.messages import (
    GateState,
    HalStatus,
    Hold,
    JointState,
    Lease,
    ResetEpisode,
    ResetEpisodeReply,
    StopLevel,
    decode,
    encode,
)
from fairlead.wire.bus import Qos, Sample
from tests.hal.gate_messages import N_DOF, PARTS, PERIOD_NS, SESSION, chunk, grant, lease
from tests.hal.running_host import (
    KEYS,
    RunningHost,
    wait_until,
)


def answer_with_leases(running: RunningHost, state: Callable[[], GateState]) -> None:
    """A gate that answers every joint state, be it a repeat, with a lease."""
    leases, seq = running.bus.publisher(KEYS.lease, Lease, Qos.HOT), count(1)

    def answer(sample: Sample) -> None:
        tick = decode(JointState, sample.payload).tick
        leases.put(lease(next(seq), tick, state=state()))

    running.bus.subscribe(KEYS.joints, answer)
    wait_until(lambda: len(running.states) > 1)


class ResettingRobot:
    """A running host, its gate, and what the host's status said while the backend was reset."""

    def __init__(self, running: RunningHost, pacing: Pacing) -> None:
        self.running = running
        self.pacing = pacing
        self.gate = GateState.DISARMED
        self.arms_at_reset = False
        self.said_at_reset: list[str] = []
        self.steps_at_reset = 0
        self.goes_on_at_reset: list[bool] = []
        self._reset = running.backend.reset
        running.backend.reset = self._on_reset  # type: ignore[method-assign]
        answer_with_leases(running, lambda: self.gate)

    def _on_reset(self, seed: int) -> None:
        self.said_at_reset.append(self.running.status().state)
        self.steps_at_reset = len(self.running.backend.applied)
        self.goes_on_at_reset = [self.running.pulse.goes_on() for _ in range(3)]
        self.gate = GateState.ARMED if self.arms_at_reset else self.gate
        self._reset(seed)

    def arm_once_it_says_resetting(self) -> None:
        """A gate that was armed just before it could read the status."""

        def look(sample: Sample) -> None:
            if decode(HalStatus, sample.payload).state == "resetting":
                self.gate = GateState.ARMED

        self.running.bus.subscribe(KEYS.hal_status, look)

    def reset(self) -> ResetEpisodeReply:
        return asyncio.run(self.running.host.resets.handle(encode(ResetEpisode(seed=1))))


@pytest.fixture(params=["realtime", "lockstep"])
def robot(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[ResettingRobot]:
    pacing: Pacing = request.param
    host = RunningHost(tmp_path, pacing)
    yield ResettingRobot(host, pacing)
    host.close()


def test_the_status_says_resetting_before_the_backend_is_reset(robot: ResettingRobot) -> None:
    reply = robot.reset()
    assert robot.said_at_reset == ["resetting"]
    assert reply.held_ticks >= 1
    assert robot.running.status().state == "ready"
    assert not robot.running.stops


def test_a_reset_longer_than_systemd_s_watchdog_is_no_hanging_driver(robot: ResettingRobot) -> None:
    robot.reset()
    assert robot.goes_on_at_reset == [True] * 3
    ticks = len(robot.running.states)
    wait_until(lambda: len(robot.running.states) > ticks)
    asked = [robot.running.pulse.goes_on() for _ in range(9)]
    assert not all(asked), "it is asked more often than it beats"


def test_a_gate_that_was_armed_meanwhile_keeps_its_episode(robot: ResettingRobot) -> None:
    robot.arm_once_it_says_resetting()
    with pytest.raises(RefusedError, match="needs a disarmed gate, it is armed"):
        robot.reset()
    assert robot.said_at_reset == []
    wait_until(lambda: robot.running.status().state == "ready")


def test_a_silent_gate_may_be_armed(robot: ResettingRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(episode_reset, "SILENT_NS", 200_000_000)
    monkeypatch.setattr(episode_reset, "SEEN_NS", 1 << 62)
    with pytest.raises(RefusedError, match="the gate is silent, so it may be armed"):
        robot.reset()
    assert robot.said_at_reset == []
    wait_until(lambda: robot.running.status().state == "ready")


def test_a_gate_that_armed_all_the_same_is_stopped(robot: ResettingRobot) -> None:
    robot.arms_at_reset = True
    robot.reset()
    wait_until(lambda: bool(robot.running.stops))
    stop: StopLevel = robot.running.stops[0]
    assert stop.reason == "the gate was armed while the episode was reset"
    wait_until(lambda: robot.running.status().state == "holding")


def test_a_world_in_lockstep_takes_no_step_before_it_is_reset(tmp_path: Path) -> None:
    running = RunningHost(tmp_path, "lockstep")
    robot = ResettingRobot(running, "lockstep")
    reply = robot.reset()
    assert robot.steps_at_reset == 0
    assert (reply.tick, reply.episode_tick, reply.held_ticks) == (2, 2, 1)
    running.close()


def test_rows_of_the_old_episode_do_not_act_in_the_new_one() -> None:
    core = HalCore(SESSION, "realtime", PARTS, N_DOF, PERIOD_NS)
    assert core.on_lease(lease(1, 1, [grant(10)]), 0) == ""
    assert core.on_safe_chunk(chunk(1, first_tick=2)) == ""
    core.set_resetting(True)
    core.decide(1, 0, is_still=True)
    core.set_resetting(False)
    plan = core.decide(2, 1, is_still=True)
    assert isinstance(plan, TickPlan) and not plan.commands


def test_a_reset_the_driver_does_not_know_is_refused_and_ticks_go_on(
    robot: ResettingRobot,
) -> None:
    running = robot.running
    running.backend.refuses_resets = True
    with pytest.raises(ConfigError, match="hardware has no episodes"):
        robot.reset()
    if robot.pacing == "realtime":
        steps = len(running.backend.applied)
        wait_until(lambda: len(running.backend.applied) > steps + 2)
        assert running.states[-1].acted[0].hold != Hold.RESETTING
    wait_until(lambda: running.status().state == "ready")
