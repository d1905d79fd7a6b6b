"""Stops, latches, and what survives the end of the process."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from fairlead.errors import RefusedError
from fairlead.messages import GateState, GateStatus, pack_floats

pytestmark = pytest.mark.processes


def send_nan(scene: Scene) -> None:
    values = pack_floats(np.full((1, 6), np.nan))
    scene.send(scene.chunk(rows=1, parts=(scene.arm_part(values=values),)))


def latch(scene: Scene) -> GateStatus:
    """Make the gate stop three times in a row."""
    for _ in range(2):
        send_nan(scene)
        scene.reset(scene.wait_state(GateState.STOPPED).stop_ids[0])
        scene.wait_state(GateState.DISARMED)
        scene.arm()
        scene.take_claim()
    send_nan(scene)
    return scene.wait_state(GateState.LATCHED)


def test_an_operator_stop_ends_claims_and_is_listed_until_reset(scene: Scene) -> None:
    scene.ready_to_move()
    scene.raise_stop(77)
    lease = scene.leases.wait_for(lambda m: m.stop_ids == (77,))
    assert (lease.state, lease.grants) == (GateState.STOPPED, ())
    status = scene.wait_state(GateState.STOPPED)
    assert status.claims == ()
    assert "fairlead reset" in status.fix

    scene.reset(77)
    scene.wait_state(GateState.DISARMED)
    scene.arm()


def test_a_stop_that_was_reset_does_not_come_back_with_a_late_copy(scene: Scene) -> None:
    scene.ready_to_move()
    scene.raise_stop(77)
    scene.wait_state(GateState.STOPPED)
    scene.reset(77)
    scene.raise_stop(77)
    scene.raise_stop(78)
    lease = scene.leases.wait_for(lambda m: 78 in m.stop_ids)
    assert lease.stop_ids == (78,)


def test_a_stop_reaches_a_disarmed_gate_too(scene: Scene) -> None:
    scene.meet_hal()
    scene.raise_stop(5)
    scene.wait_state(GateState.STOPPED)
    with pytest.raises(RefusedError) as refusal:
        scene.arm()
    assert "fairlead reset" in refusal.value.fix


def test_a_reset_with_another_id_is_refused(scene: Scene) -> None:
    scene.ready_to_move()
    scene.raise_stop(77)
    scene.wait_state(GateState.STOPPED)
    with pytest.raises(RefusedError):
        scene.reset(76)
    assert scene.status().state == GateState.STOPPED


def reset_latch(scene: Scene, latch_id: int) -> None:
    """The robot stands still for ten states, then the operator resets."""
    for _ in range(12):
        scene.next_tick(scene.hal.held())
    scene.reset(latch_id)
    scene.wait_state(GateState.DISARMED)


def test_an_arm_that_moves_while_its_velocities_say_zero_is_not_at_standstill(scene: Scene) -> None:
    scene.ready_to_move()
    verdict = scene.send(scene.chunk())
    scene.acted_on(verdict, 0)
    scene.raise_stop(77)
    scene.wait_state(GateState.STOPPED)
    for _ in range(scene.ramp_ticks + 1):
        scene.hal.positions[scene.hal.joints.index("panda_joint1")] += 0.01
        scene.next_tick(scene.hal.held())
    status = scene.wait_state(GateState.LATCHED)
    assert "G043 arm panda_joint1: 0.2 rad/s, limit 0.05 rad/s" in status.cause
    with pytest.raises(RefusedError, match="a joint is still moving"):
        scene.reset(status.latch_id)


def test_three_stops_of_the_gate_itself_latch_it(scene: Scene) -> None:
    scene.ready_to_move()
    status = latch(scene)
    assert status.latch_id != 0
    with pytest.raises(RefusedError):
        scene.reset(status.latch_id ^ 1)
    reset_latch(scene, status.latch_id)


def test_a_latch_survives_a_restart_with_its_id(scene: Scene) -> None:
    scene.ready_to_move()
    latch_id = latch(scene).latch_id
    assert scene.gate.stop() == 0
    scene.restart_gate()
    status = scene.status()
    assert (status.state, status.latch_id) == (GateState.LATCHED, latch_id)
    scene.meet_hal()
    reset_latch(scene, latch_id)
    assert scene.gate.stop() == 0
    scene.restart_gate()
    assert scene.status().state == GateState.DISARMED


def test_a_latch_that_cannot_be_written_holds_and_is_in_the_log(scene: Scene) -> None:
    scene.ready_to_move()
    (scene.state_dir / "latch" / "occupied").mkdir(parents=True)  # no file can replace it
    latch(scene)
    scene.gate.wait_line(f"WARNING safety: cannot replace {scene.state_dir}/latch")
    assert scene.status().state == GateState.LATCHED


@pytest.mark.parametrize("after", ["arm", "stop"])
def test_a_gate_killed_while_not_disarmed_boots_latched(scene: Scene, after: str) -> None:
    scene.meet_hal()
    scene.arm()
    if after == "stop":
        scene.raise_stop(3)
        scene.wait_state(GateState.STOPPED)
    scene.gate.kill()
    scene.restart_gate()
    status = scene.status()
    assert status.state == GateState.LATCHED
    assert "the last exit was not clean" in status.cause
    scene.meet_hal()
    with pytest.raises(RefusedError):
        scene.arm()
    reset_latch(scene, status.latch_id)
    scene.arm()


def test_a_gate_killed_while_disarmed_boots_disarmed(scene: Scene) -> None:
    scene.meet_hal()
    scene.arm()
    scene.disarm()
    # The clean mark is written by a thread of its own.
    mark = scene.state_dir / "clean_mark"
    scene.leases.wait_for(lambda m: mark.exists())
    scene.gate.kill()
    scene.restart_gate()
    assert scene.status().state == GateState.DISARMED


def test_ending_on_request_while_armed_disarms_and_boots_clean(scene: Scene) -> None:
    scene.ready_to_move()
    scene.leases.skip()
    assert scene.gate.stop() == 0
    last = scene.leases.wait_for(lambda m: m.state == GateState.DISARMED)
    assert last.grants == ()
    scene.restart_gate()
    assert scene.status().state == GateState.DISARMED


def test_a_new_session_of_the_hal_disarms(scene: Scene) -> None:
    scene.ready_to_move()
    scene.hal.session += 1
    scene.hal.tick = 0
    scene.hal.publish_status()
    scene.hal.publish_state()
    status = scene.wait_state(GateState.DISARMED)
    assert status.claims == ()


def test_realtime_silence_of_the_hal_stops(make_scene: Callable[..., Scene]) -> None:
    scene = make_scene("realtime")
    scene.meet_hal()
    scene.arm()
    status = scene.wait_state(GateState.STOPPED)
    assert dict(status.counters)["G011"] == 1


def test_a_claim_whose_heartbeat_ends_is_ended(scene: Scene) -> None:
    scene.ready_to_move()
    scene.statuses.wait_for(lambda m: len(m.claims) == 1)
    scene.silence()
    scene.statuses.wait_for(lambda m: m.claims == ())
    assert scene.status().state == GateState.ARMED
