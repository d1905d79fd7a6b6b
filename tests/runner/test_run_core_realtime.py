"""Realtime stories: observing early enough, losing rows by index, starving honestly."""

from __future__ import annotations

import msgspec
import pytest

from fairlead.messages import GateState, Image, Outcome
from fairlead.skill.manifest import SkillManifest
from tests.runner.scripted_robot import (
    CLAIM,
    EPOCH,
    NO_ROW,
    SESSION,
    SKILL,
    Story,
    broken_layout,
    joints,
    layout,
    lease,
    rows,
    story,
    task,
)


@pytest.fixture
def run() -> Story:
    return story(lockstep=False)


def test_before_the_first_joint_state_nothing_is_asked_and_the_phase_says_what_is_awaited(
    run: Story,
) -> None:
    run.take(run.core.on_task(task(5), 0.0))
    run.take(run.core.on_layout(layout(5), 0.0))
    run.take(run.core.on_time(1.0))
    assert (run.asked, run.sent) == ([], [])
    assert run.core.phase == "waiting for a joint state"
    run.take(run.core.on_joints(joints(5), 1.0))
    assert run.seen_ticks() == [5]


def test_the_next_observation_leaves_spare_ticks_before_the_rows_run_out(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)  # d = 1: obs 10, first live row 11; 8 rows last to 17
    for tick in range(11, 15):
        run.tick(tick)
    assert run.seen_ticks() == [10]
    run.tick(15)  # 10 + (8 - 1 - 2)
    assert run.seen_ticks() == [10, 15]


def test_a_slow_policy_is_asked_earlier(run: Story) -> None:
    run.tick(10)
    for tick in range(11, 13):
        run.tick(tick)
    run.answer()  # arrives during tick 12
    run.judge(first=13)  # d = 3
    assert run.seen_ticks() == [10]
    run.tick(13)  # 10 + (8 - 3 - 2)
    assert run.seen_ticks() == [10, 13]


def test_a_policy_slower_than_its_horizon_is_asked_at_every_new_tick(run: Story) -> None:
    run.tick(10)
    for tick in range(11, 21):
        run.tick(tick)
    run.answer()
    run.judge(Outcome.REFUSED)
    assert run.seen_ticks() == [10, 20]


def test_execute_steps_bounds_the_spacing() -> None:
    skill = SkillManifest.model_validate(SKILL.model_dump(mode="json") | {"execute_steps": 2})
    run = story(lockstep=False, skill=skill)

    def tick(number: int) -> None:
        run.take(run.core.on_task(task(number), 0.0))
        run.take(run.core.on_joints(joints(number), 0.0))
        seen = msgspec.structs.replace(layout(number), skill_hash=skill.skill_hash)
        run.take(run.core.on_layout(seen, 0.0))

    tick(10)
    run.answer()
    assert run.chunk.horizon == 8, "rows beyond execute_steps are the reserve"
    run.judge(first=11)
    tick(11)
    tick(12)
    assert run.seen_ticks() == [10, 12]


def test_one_question_at_a_time(run: Story) -> None:
    for tick in range(10, 30):
        run.tick(tick)
    assert run.seen_ticks() == [10]


def test_without_a_verdict_the_bytes_are_sent_again_each_tick_while_a_row_is_left(
    run: Story,
) -> None:
    run.tick(10)
    run.answer()
    for tick in range(11, 15):
        run.tick(tick)
    assert len(run.sent) == 5
    assert len(set(run.sent)) == 1


def test_a_refused_chunk_is_followed_by_the_next_tick(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(Outcome.REFUSED)
    assert run.seen_ticks() == [10]
    run.tick(11)
    assert run.seen_ticks() == [10, 11]


def test_a_truncated_chunk_brings_the_next_observation_forward(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(Outcome.TRUNCATED, first=11, last=14)
    run.tick(11)
    assert run.seen_ticks() == [10]
    run.tick(12)  # 10 + (5 - 1 - 2)
    assert run.seen_ticks() == [10, 12]


def test_ticks_without_a_row_are_counted_once_rows_have_run(run: Story) -> None:
    run.tick(10, acted=NO_ROW)
    assert run.core.starved == 0
    run.answer()
    run.judge(first=11)
    run.tick(11, acted=NO_ROW)  # tick 10 had none
    run.tick(12)
    assert run.core.starved == 1


def test_success_ends_the_goal_at_once(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)
    run.take(run.core.on_task(task(11, success=True), 0.0))
    assert run.core.result is not None
    assert run.core.result.outcome == "succeeded"


def test_the_oldest_input_travels_with_the_chunk(run: Story) -> None:
    run.take(run.core.on_task(task(10), 0.0))
    run.take(run.core.on_joints(joints(10), 0.0))
    run.take(run.core.on_layout(layout(10, oldest=7), 0.0))
    run.answer(rows(3))
    assert (run.chunk.obs_tick, run.chunk.oldest_tick, run.chunk.horizon) == (10, 7, 3)


def test_queue_depth_is_the_released_rows_after_the_newest_tick(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)
    run.tick(11)
    assert run.core.queue_depth == 6


def test_a_joint_state_of_another_session_ends_nothing_until_the_gate_follows_it(
    run: Story,
) -> None:
    run.tick(10)
    run.take(run.core.on_joints(joints(999, session=0xAB), 0.0))
    assert (run.core.result, run.core.tick) == (None, 10)
    follows = msgspec.structs.replace(lease(1, claims=(CLAIM,)), session=0xAB)
    run.take(run.core.on_lease(follows))
    assert run.core.result is not None
    assert (run.core.result.kind, run.core.result.detail) == (
        "claim_lost", "claim of runner lost: the gate follows another HAL session",
    )  # fmt: skip


def test_a_claim_that_was_granted_and_no_longer_is_fails_the_goal(run: Story) -> None:
    run.core.on_lease(lease(1, claims=()))  # published before the claim was taken
    run.core.on_lease(lease(2, claims=(CLAIM,)))
    assert run.core.result is None
    run.core.on_lease(lease(3, claims=(5,)))
    result = run.core.result
    assert result is not None
    assert (result.kind, result.detail) == (
        "claim_lost", "claim of runner lost: the gate no longer grants it",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("state", "word"),
    [
        (GateState.STOPPED, "stopped"),
        (GateState.LATCHED, "latched"),
        (GateState.DISARMED, "disarmed"),
    ],
)
def test_a_gate_that_is_not_armed_fails_the_goal(run: Story, state: GateState, word: str) -> None:
    run.core.on_lease(lease(1, claims=(CLAIM,)))
    run.core.on_lease(lease(2, state=state, claims=()))
    assert run.core.result is not None
    assert run.core.result.detail == f"claim of runner lost: the gate is {word}"


def test_a_new_epoch_fails_the_goal_but_a_late_lease_of_an_old_one_does_not(run: Story) -> None:
    run.core.on_lease(lease(900, epoch=EPOCH + 1, claims=()))
    assert run.core.result is None
    run.core.on_lease(lease(2, claims=(CLAIM,)))
    run.core.on_lease(lease(1, claims=()))  # reordered
    assert run.core.result is None
    run.core.on_lease(lease(1, epoch=EPOCH + 2, claims=()))
    assert run.core.result is not None
    assert run.core.result.detail == "claim of runner lost: the gate started a new epoch"


def test_a_claim_that_is_never_granted_fails_the_goal(run: Story) -> None:
    for seq in range(1, 81):
        run.core.on_lease(lease(seq, claims=()))
    assert run.core.result is None
    run.core.on_lease(lease(81, claims=()))
    assert run.core.result is not None
    assert run.core.result.detail == "claim of runner lost: the gate never granted it"


def test_endless_refusals_stall_and_the_last_one_is_told(run: Story) -> None:
    for tick in range(10, 13):
        run.now_s += 2.0
        run.tick(tick)
        run.answer()
        run.judge(Outcome.REFUSED)
    run.take(run.core.on_time(run.now_s))
    result = run.core.result
    assert result is not None
    assert result.detail == (
        "no rows released for 6.0 s, waiting for released rows at tick 12; last refusal: "
        "G020 limit: chunk 3 refused at row 2, arm linear: 5, limit 0.0867"
    )


def test_a_camera_that_skips_pictures_stalls_a_goal_that_looks_back_and_the_spacing_is_told() -> (
    None
):
    eye = {"eye": {"camera": "front", "width": 2, "height": 3, "deltas": [-1, 0]}}
    skill = SkillManifest.model_validate(SKILL.model_dump(mode="json") | {"images": eye})
    run = story(lockstep=False, skill=skill, camera_periods={"front": 1}, periods=2)
    for tick in range(10, 100):
        run.now_s = tick * 0.1
        if tick % 3 == 1:
            image = Image(session=SESSION, tick=tick, camera="front", width=2, height=3,
                          encoding_name="rgb8", data=bytes(range(18)))  # fmt: skip
            run.take(run.core.on_image(image, run.now_s))
        run.tick(tick)
        if tick == 10:
            run.answer()
            run.judge(first=11)
    run.take(run.core.on_joints(joints(100), run.now_s))  # its layout is under way
    run.take(run.core.on_time(run.now_s))
    assert run.seen_ticks() == [10]
    result = run.core.result
    assert result is not None and result.kind == "stalled"
    assert result.detail.endswith(
        "waiting for image eye of tick 95 from camera front (its deltas want one every 2 ticks, "
        "the last came 3 ticks apart) at tick 100"
    )


def test_layout_faults_of_two_ticks_in_a_row_fail_a_goal_in_motion(run: Story) -> None:
    run.tick(5)
    run.take(run.core.on_layout(broken_layout(6), 0.0))
    run.take(run.core.on_layout(broken_layout(6), 0.0))  # one tick told twice counts once
    assert run.core.result is None
    run.take(run.core.on_layout(broken_layout(7), 0.0))
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.kind) == ("failed", "layout_missing_frame")
    assert result.detail.startswith("at tick 7: grip_site in base_site")


def test_one_good_layout_between_two_faults_keeps_a_goal_in_motion(run: Story) -> None:
    run.tick(5)
    run.take(run.core.on_layout(broken_layout(6), 0.0))
    run.take(run.core.on_layout(layout(7), 0.0))
    run.take(run.core.on_layout(broken_layout(8), 0.0))
    assert run.core.result is None


def test_before_the_first_good_layout_nothing_moves_and_three_faults_are_waited_out(
    run: Story,
) -> None:
    for tick in (5, 6, 7):
        run.take(run.core.on_layout(broken_layout(tick), 0.0))
    assert run.core.result is None
    run.take(run.core.on_layout(broken_layout(8), 0.0))
    assert run.core.result is not None
