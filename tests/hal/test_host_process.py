"""The HAL as a process on a real bus: what it publishes, refuses, logs and survives."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    Claim,
    ClaimReply,
    HalStatus,
    Hold,
    JointState,
    Lease,
    ResetEpisode,
    ResetEpisodeReply,
    SafeChunk,
    StatusQuery,
    StopLevel,
    TransformBatch,
    decode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Qos
from tests.hal.hal_process import HalProcess
from tests.hal.live_gate import LiveGate

pytestmark = pytest.mark.processes

PERIOD_MS = 50
LEASE_LIFE_MS = 75
BASE = 2


@pytest.fixture(scope="module")
def idle(tmp_path_factory: pytest.TempPathFactory) -> Iterator[HalProcess]:
    """One whom nobody commands, for all who only listen."""
    hal = HalProcess(tmp_path_factory.mktemp("idle"), "realtime")
    yield hal
    hal.close()


def drive(gate: LiveGate, horizon: int = 64) -> None:
    """Claim the base and offer rows that keep it moving slowly for ``horizon`` ticks."""
    robot = load_robot("panda_mobile")
    request = Claim(
        source="runner",
        skill="test",
        skill_hash=bytes([7]) * 32,
        robot_hash=robot.robot_hash,
        period_ns=robot.tick_period_ns,
        parts=("base",),
        chunk_rate_hz=20.0,
        horizon_max=64,
        age_max_ticks=10,
        limits=(),
    )
    gate.offer(slow_base(gate.claim(request), gate.newest_tick, horizon))


def slow_base(claim: ClaimReply, start: int, horizon: int) -> ActionChunk:
    """Rows from tick ``start`` on that move the base along x at 0.1 m/s."""
    robot = load_robot("panda_mobile")
    values = np.zeros((horizon, robot.n_dof))
    values[:, 0] = 0.1
    part = ActionPart(
        part=BASE,
        mode=ControlMode.JOINT_VELOCITY,
        frame_id="",
        values=pack_floats(values),
        active=(0, 1, 2),
    )
    return ActionChunk(
        robot_hash=robot.robot_hash,
        session=claim.session,
        epoch=claim.epoch,
        claim_id=claim.claim_id,
        source="runner",
        seq=1,
        goal_id=1,
        obs_tick=start,
        oldest_tick=start,
        start_tick=start,
        horizon=horizon,
        parts=(part,),
        trace=NO_TRACE,
    )


def reset(hal: HalProcess, seed: int) -> ResetEpisodeReply:
    key = hal.keys.hal_command("reset_episode")
    return decode(ResetEpisodeReply, hal.bus.query(key, ResetEpisode(seed=seed), 20.0))


def test_status_names_the_robot_its_parts_and_its_pacing(idle: HalProcess) -> None:
    idle.wait_until(lambda: bool(idle.motion()), "the first tick")
    status = decode(HalStatus, idle.bus.query(idle.keys.hal_status, StatusQuery(), 5.0))
    robot = load_robot("panda_mobile")
    assert status.robot_hash == robot.robot_hash
    assert status.joints == robot.joint_names
    assert tuple(part.name for part in status.parts) == robot.part_names
    assert (status.pacing, status.period_ns, status.state) == ("realtime", 50_000_000, "ready")


def test_realtime_ticks_come_in_order_at_the_control_rate(idle: HalProcess) -> None:
    states = [decode(JointState, s.payload) for s in idle.collect(idle.keys.joints, 20)]
    ticks = [state.tick for state in states]
    assert ticks == list(range(ticks[0], ticks[0] + 20))
    assert {part.hold for state in states for part in state.acted} == {Hold.STARTING}
    spans = np.diff([state.stamp_ns for state in states]) / 1e6
    assert 45 <= np.median(spans) <= 60


def test_each_tick_sends_its_transforms_before_its_joints(idle: HalProcess) -> None:
    samples = idle.collect(f"{idle.keys.namespace}/{idle.keys.robot}/**", 60)
    newest_transform = 0
    for sample in samples:
        if sample.key == idle.keys.tf("hal"):
            batch = decode(TransformBatch, sample.payload)
            newest_transform = newest_transform if batch.is_static else batch.tick
        elif sample.key == idle.keys.joints and newest_transform:
            assert decode(JointState, sample.payload).tick == newest_transform


def test_static_transforms_come_again_for_late_joiners(idle: HalProcess) -> None:
    batches = [
        decode(TransformBatch, sample.payload) for sample in idle.collect(idle.keys.tf("hal"), 45)
    ]
    static = [batch for batch in batches if batch.is_static]
    assert 1 <= len(static) <= 4
    assert [(t.parent, t.child) for t in static[0].transforms] == [("map", "odom")]


def test_a_paused_lockstep_world_repeats_its_tick_in_identical_bytes(lockstep: HalProcess) -> None:
    samples = lockstep.collect(lockstep.keys.joints, 4)
    assert len({sample.payload for sample in samples}) == 1
    assert decode(JointState, samples[0].payload).tick == 1
    assert lockstep.motion() == []


def test_a_lockstep_claim_steps_the_world_row_by_row(lockstep: HalProcess) -> None:
    with closing(LiveGate(lockstep.bus, lockstep.keys)) as gate:
        lockstep.wait_until(lambda: gate.newest_tick == 1, "the first state")
        gate.arm()
        drive(gate, horizon=16)
        lockstep.wait_until(lambda: len(lockstep.motion()) >= 16, "16 rows")
    motion = lockstep.motion()
    assert [line["tick"] for line in motion] == list(range(1, 17))
    assert [line["acted"][BASE][2] for line in motion] == list(range(16))
    assert {line["acted"][BASE][0] for line in motion} == {0}
    trace = (lockstep.state_dir / "trace.jsonl").read_text().splitlines()
    assert len(trace) == 16


def test_when_the_gate_falls_silent_the_ramp_begins_within_the_lease_life_and_a_tick(
    realtime: HalProcess,
) -> None:
    with closing(LiveGate(realtime.bus, realtime.keys)) as gate:
        realtime.wait_until(lambda: gate.newest_tick > 1, "a state")
        gate.arm()
        drive(gate)
        realtime.wait_until(lambda: not realtime.motion()[-1]["acted"][BASE][0], "motion")
        last_lease_ns = gate.silence()
        realtime.wait_until(
            lambda: realtime.motion()[-1]["acted"][BASE][0] == Hold.LEASE_STALE, "the hold"
        )
    moved = [line for line in realtime.motion() if not line["acted"][BASE][0]]
    held = next(line for line in realtime.motion() if line["tick"] > moved[-1]["tick"])
    assert held["acted"][BASE][0] == Hold.LEASE_STALE
    ramp_ms = (held["stamp_ns"] - last_lease_ns) / 1e6
    print(f"ramp begun {ramp_ms:.1f} ms after the last lease")
    assert ramp_ms <= LEASE_LIFE_MS + PERIOD_MS + 5
    assert (moved[-1]["stamp_ns"] - last_lease_ns) / 1e6 <= LEASE_LIFE_MS + 5
    assert held["tick"] == moved[-1]["tick"] + 1


def test_garbage_on_every_key_it_reads_does_not_disturb_a_tick(realtime: HalProcess) -> None:
    keys = realtime.keys
    for key, kind in ((keys.lease, Lease), (keys.safe("x"), SafeChunk), (keys.stop, StopLevel)):
        publisher = realtime.bus.publisher(key, kind, Qos.HOT)
        for payload in (b"", b"\x00", b"\x93\x09\x01\x00", bytes(70_000)):
            publisher.put_bytes(payload)
    states = [decode(JointState, s.payload) for s in realtime.collect(keys.joints, 10)]
    ticks = [state.tick for state in states]
    assert ticks == list(range(ticks[0], ticks[0] + 10))
    realtime.wait_until(lambda: "StopLevel that cannot be read" in realtime.log.read_text(), "log")
    assert realtime.log.read_text().count("Lease that cannot be read") == 1


def test_a_stop_is_held_and_repeated_until_a_gate_lists_it(realtime: HalProcess) -> None:
    stop = StopLevel(stop_id=77, by="operator", reason="test")
    realtime.bus.publisher(realtime.keys.stop, StopLevel, Qos.HOT).put(stop)
    repeats = realtime.collect(realtime.keys.stop, 5)
    assert {decode(StopLevel, sample.payload).stop_id for sample in repeats} == {77}
    status = decode(HalStatus, realtime.bus.query(realtime.keys.hal_status, StatusQuery(), 5.0))
    assert (status.state, status.detail) == ("holding", "stop 000000000000004d (test)")


def test_a_stop_too_long_for_the_gate_gets_an_id_that_can_be_reset(realtime: HalProcess) -> None:
    long = StopLevel(stop_id=78, by="operator", reason="a" * 70_000)
    realtime.bus.publisher(realtime.keys.stop, StopLevel, Qos.HOT).put(long)

    def own() -> list[int]:
        samples = realtime.collect(realtime.keys.stop, 1)
        stops = [decode(StopLevel, one.payload) for one in samples]
        return [one.stop_id for one in stops if len(one.reason) < 1000]

    realtime.wait_until(lambda: bool(own()), "a stop of its own")
    assert 78 not in own()

    def is_holding() -> bool:
        answer = realtime.bus.query(realtime.keys.hal_status, StatusQuery(), 5.0)
        return decode(HalStatus, answer).state == "holding"

    realtime.wait_until(is_holding, "the status")


def test_a_killed_hal_leaves_every_decided_tick_in_its_log(realtime: HalProcess) -> None:
    realtime.collect(realtime.keys.joints, 20)
    state = decode(JointState, realtime.collect(realtime.keys.joints, 1)[0].payload)
    realtime.process.kill()
    realtime.process.wait(timeout=10)
    ticks = [line["tick"] for line in realtime.motion()]
    assert ticks == list(range(1, len(ticks) + 1))
    assert len(ticks) >= state.tick - 1


def test_a_full_disk_is_said_once_and_control_goes_on(tmp_path: Path) -> None:
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "motion.jsonl").symlink_to("/dev/full")
    hal = HalProcess(tmp_path, "realtime")
    hal.collect(hal.keys.joints, 20)
    assert hal.log.read_text().count("no longer recorded: No space left on device") == 1
    hal.close()


def test_options_that_do_not_fit_name_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="the HAL ended") as caught:
        HalProcess(tmp_path, "realtime", seed="first", colour="red")
    text = str(caught.value)
    assert "seed: Input should be a valid integer, unable to parse" in text
    assert "colour: unknown key (valid: frames, seed, trace)" in text
    assert "Traceback" not in text
