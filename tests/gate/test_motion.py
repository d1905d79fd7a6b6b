"""From arm to released rows: what the HAL is given, in which order, and what the runner hears."""

from __future__ import annotations

import numpy as np
import pytest

from bench.equipment.gate_scene import DELTA_M, SOURCE, Scene
from fairlead.errors import RefusedError
from fairlead.messages import Decision, GateState, Outcome, floats

pytestmark = pytest.mark.processes


def test_a_good_chunk_is_released_leased_and_answered(scene: Scene) -> None:
    scene.meet_hal()
    armed = scene.arm()
    claimed = scene.take_claim()
    assert (claimed.epoch, claimed.session) == (armed.epoch, scene.hal.session)

    chunk = scene.chunk()
    verdict = scene.send(chunk)

    assert (verdict.outcome, verdict.code) == (Outcome.RELEASED, 0)
    now = chunk.start_tick
    assert (verdict.released_first, verdict.released_last) == (now, now + 7)
    assert 0 < verdict.latency_ns < 50_000_000
    safe = scene.safe.wait_for()
    assert (safe.verdict_id, safe.first_tick, safe.horizon) == (verdict.verdict_id, now, 8)
    assert (safe.claim_id, safe.epoch, safe.source) == (scene.claim_id, armed.epoch, SOURCE)
    np.testing.assert_array_equal(floats(safe.parts[0].values, 6)[:, 0], DELTA_M)
    lease = scene.leases.wait_for(lambda m: bool(m.grants) and m.grants[0].decision == Decision.ROW)
    assert lease.grants[0].verdict_id == verdict.verdict_id
    assert lease.grants[0].until_tick == lease.state_tick == scene.hal.tick
    assert lease.state == GateState.ARMED


def test_released_rows_stay_released_while_the_robot_executes_them(scene: Scene) -> None:
    scene.ready_to_move()
    first = scene.send(scene.chunk(rows=4))
    for row in range(3):
        scene.acted_on(first, row)
        lease = scene.leases.wait_for(lambda m: m.grants[0].decision == Decision.ROW)
        assert lease.state_tick == scene.hal.tick
        assert lease.grants[0].verdict_id == first.verdict_id
    second = scene.send(scene.chunk(rows=4))
    assert (second.outcome, second.released_first) == (Outcome.RELEASED, scene.hal.tick)
    assert second.verdict_id > first.verdict_id


def test_rows_a_part_did_not_execute_are_judged_again(scene: Scene) -> None:
    scene.ready_to_move()
    first = scene.send(scene.chunk(rows=4))
    scene.safe.skip()
    scene.next_tick(scene.hal.held())
    again = scene.safe.wait_for(lambda m: m.verdict_id != first.verdict_id)
    assert again.first_tick == scene.hal.tick
    assert again.after.hold != 0


def test_a_lost_safe_chunk_is_repeated_until_the_hal_has_acted_on_it(scene: Scene) -> None:
    scene.ready_to_move()
    verdict = scene.send(scene.chunk())
    scene.safe.skip()
    scene.hal.repeat_state()
    assert scene.safe.wait_for().verdict_id == verdict.verdict_id


def test_the_identical_chunk_gets_the_identical_answer(scene: Scene) -> None:
    scene.ready_to_move()
    chunk = scene.chunk()
    first = scene.send(chunk)
    second = scene.send(chunk)
    assert (second.verdict_id, second.outcome) == (first.verdict_id, Outcome.RELEASED)


def test_leases_go_on_without_states(scene: Scene) -> None:
    scene.meet_hal()
    first = scene.leases.wait_for()
    tenth = scene.leases.wait_for(lambda m: m.lease_seq >= first.lease_seq + 10)
    assert tenth.grants == ()
    assert tenth.state == GateState.DISARMED


def test_a_part_that_is_held_is_refused_naming_its_holder(scene: Scene) -> None:
    scene.ready_to_move()
    with pytest.raises(RefusedError) as refusal:
        scene.claim("arm", "gripper", source="teleop")
    assert refusal.value.who == "safety"
    assert SOURCE in refusal.value.reason and "arm" in refusal.value.reason


def test_two_claims_on_different_parts_are_both_granted(scene: Scene) -> None:
    scene.ready_to_move()
    scene.claim("gripper", source="teleop")
    lease = scene.leases.wait_for(lambda m: len(m.grants) == 2)
    assert {grant.source for grant in lease.grants} == {SOURCE, "teleop"}


def test_a_released_claim_is_free_for_the_next(scene: Scene) -> None:
    scene.ready_to_move()
    scene.release()
    assert scene.claim(source="teleop").claim_id != scene.claim_id


def test_claiming_while_disarmed_is_refused_with_the_command_that_arms(scene: Scene) -> None:
    scene.meet_hal()
    with pytest.raises(RefusedError) as refusal:
        scene.claim()
    assert "disarmed" in refusal.value.reason
    assert "fairlead arm" in refusal.value.fix


def test_arming_without_a_hal_is_refused(scene: Scene) -> None:
    with pytest.raises(RefusedError):
        scene.arm()
    assert scene.status().state == GateState.DISARMED


def test_a_claim_for_another_robot_is_refused(scene: Scene) -> None:
    scene.meet_hal()
    scene.arm()
    with pytest.raises(RefusedError):
        scene.claim(robot_hash=bytes(32))
