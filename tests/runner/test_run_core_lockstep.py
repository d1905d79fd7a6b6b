"""Lockstep stories: when the policy is asked, what is sent, and what is sent again."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from fairlead.errors import PolicyError
from fairlead.messages import Outcome
from fairlead.skill.manifest import SkillManifest
from tests.runner.scripted_robot import (
    SKILL,
    Story,
    broken_layout,
    joints,
    rows,
    setup,
    story,
    task,
)
from tests.runner.scripted_robot import layout as layout_of


@pytest.fixture
def run() -> Story:
    return story(lockstep=True)


def test_the_policy_is_asked_once_the_whole_observation_of_the_tick_is_there(run: Story) -> None:
    run.take(run.core.on_joints(joints(5), 0.0))
    run.take(run.core.on_layout(layout_of(5), 0.0))
    assert run.asked == [], "the task state of tick 5 is missing"
    run.take(run.core.on_task(task(5), 0.0))
    assert run.seen_ticks() == [5]
    np.testing.assert_array_equal(run.asked[0].observation.state, np.full(30, 5.0))
    assert run.asked[0].observation.prompt == "pick"


def test_a_layout_of_an_earlier_tick_is_not_used(run: Story) -> None:
    run.take(run.core.on_task(task(5), 0.0))
    run.take(run.core.on_layout(layout_of(4), 0.0))
    run.take(run.core.on_joints(joints(5), 0.0))
    assert run.asked == []


def test_one_chunk_for_all_parts_starts_at_the_observations_tick(run: Story) -> None:
    run.tick(5)
    run.answer()
    chunk = run.chunk
    assert (chunk.seq, chunk.obs_tick, chunk.start_tick, chunk.oldest_tick) == (1, 5, 5, 5)
    assert (chunk.horizon, chunk.source, chunk.claim_id, chunk.epoch) == (8, "runner", 33, 22)
    assert [part.part for part in chunk.parts] == [0, 1, 2, 3]


def test_the_next_question_comes_when_no_released_row_is_left(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge()
    for tick in range(6, 13):
        run.tick(tick)
    assert run.seen_ticks() == [5]
    run.tick(13)
    assert run.seen_ticks() == [5, 13]
    run.answer()
    assert run.chunk.seq == 2


def test_at_most_execute_steps_rows_are_sent() -> None:
    skill = SkillManifest.model_validate(SKILL.model_dump(mode="json") | {"execute_steps": 3})
    run = story(lockstep=True, skill=skill)
    run.take(run.core.on_task(task(5), 0.0))
    run.take(run.core.on_joints(joints(5), 0.0))
    run.take(
        run.core.on_layout(msgspec.structs.replace(layout_of(5), skill_hash=skill.skill_hash), 0.0)
    )
    run.answer(rows(8))
    assert run.chunk.horizon == 3


def test_a_truncated_chunk_is_followed_by_a_question_at_the_first_missing_row(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge(Outcome.TRUNCATED, last=6)
    run.tick(6)
    run.tick(7)
    assert run.seen_ticks() == [5, 7]
    assert run.core.last_refusal == (
        "G020 limit: chunk 1 truncated at row 2, arm linear: 5, limit 0.0867"
    )


def test_a_refused_tick_is_not_asked_again_but_the_next_one_is(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge(Outcome.REFUSED)
    run.tick(5)
    assert run.seen_ticks() == [5]
    run.tick(6)
    assert run.seen_ticks() == [5, 6]
    assert run.core.last_refusal.startswith("G020 limit: chunk 1 refused at row 2")


def test_a_repeated_tick_gets_the_identical_bytes_again(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.tick(5)
    run.tick(5)
    assert len(run.sent) == 3
    assert run.sent[0] == run.sent[1] == run.sent[2]
    assert run.seen_ticks() == [5]


def test_without_a_verdict_after_one_tick_the_bytes_are_sent_again_and_nothing_is_asked(
    run: Story,
) -> None:
    run.tick(5)
    run.answer()
    run.tick(6)  # the rows were released, the verdict was lost
    assert run.sent == [run.sent[0]] * 2
    assert run.seen_ticks() == [5]
    run.judge()
    for tick in range(7, 14):
        run.tick(tick)
    assert run.seen_ticks() == [5, 13]


def test_a_repeated_tick_while_the_policy_thinks_changes_nothing(run: Story) -> None:
    run.tick(5)
    run.tick(5)
    run.tick(5)
    assert run.seen_ticks() == [5]
    run.answer()
    assert len(run.sent) == 1


def test_success_is_decided_by_the_task_at_a_decision_point_only(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge()
    for tick in range(6, 13):
        run.tick(tick, success=True)
    assert run.core.result is None
    run.tick(13, success=True)
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.decided_by, result.kind) == ("succeeded", "task", "")
    assert (result.first_tick, result.last_tick) == (5, 13)
    assert run.seen_ticks() == [5]


def test_the_deadline_counts_ticks_from_the_first_observation() -> None:
    run = story(lockstep=True, deadline_ticks=8)
    run.tick(5)
    run.answer()
    run.judge()
    for tick in range(6, 14):
        assert run.core.result is None
        run.tick(tick)
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.decided_by, result.detail) == (
        "deadline", "runner", "not done after 8 ticks",
    )  # fmt: skip


def test_a_goal_whose_every_chunk_is_refused_ends_with_their_number_and_the_last_refusal() -> None:
    run = story(lockstep=True, deadline_ticks=2)
    for tick in (5, 6):
        run.tick(tick)
        run.answer()
        run.judge(Outcome.REFUSED)
    run.tick(7)
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.detail) == (
        "deadline",
        "not done after 2 ticks; 2 of 2 chunks refused, the last: G020 limit: chunk 2 refused at "
        "row 2, arm linear: 5, limit 0.0867",
    )


def test_four_layout_faults_in_a_row_fail_the_goal_naming_frame_parent_and_age(run: Story) -> None:
    run.take(run.core.on_joints(joints(5), 0.0))
    for _ in range(3):
        run.take(run.core.on_layout(broken_layout(5), 0.0))
    assert run.core.result is None
    run.take(run.core.on_layout(broken_layout(5), 0.0))
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.kind) == ("failed", "layout_missing_frame")
    assert result.detail == (
        "at tick 5: grip_site in base_site, never seen: no transform to grip_site"
    )
    assert run.sent == []


def test_a_good_layout_between_faults_starts_the_count_again(run: Story) -> None:
    for tick in range(5, 8):
        run.take(run.core.on_layout(broken_layout(tick), 0.0))
    run.take(run.core.on_layout(layout_of(8), 0.0))
    for tick in range(9, 12):
        run.take(run.core.on_layout(broken_layout(tick), 0.0))
    assert run.core.result is None


def test_a_layout_of_another_manifest_fails_the_goal(run: Story) -> None:
    other = msgspec.structs.replace(layout_of(5), skill_hash=bytes(32))
    run.take(run.core.on_layout(other, 0.0))
    result = run.core.result
    assert result is not None
    assert result.kind == "layout_mismatch"
    assert result.detail == (
        "state_assembler sends skill hash 0000000000000000, skill oracle-counter-to-cabinet "
        f"needs {SKILL.skill_hash.hex()[:16]}"
    )


def test_a_policy_error_fails_the_goal_with_its_words(run: Story) -> None:
    run.tick(5)
    error = PolicyError("policy worker: inference took longer than 5 s")
    run.take(run.core.on_policy(1, error, 5.0))
    result = run.core.result
    assert result is not None
    assert (result.kind, result.decided_by) == ("policy_error", "policy")
    assert result.detail == "policy worker: inference took longer than 5 s"


def test_a_late_answer_after_the_end_is_never_sent(run: Story) -> None:
    run.tick(5)
    run.core.cancel("operator")
    run.answer()
    assert run.sent == []


def test_the_policys_own_time_is_no_stall(run: Story) -> None:
    run.tick(5)
    run.now_s = 60.0
    run.take(run.core.on_time(60.0))
    assert run.core.result is None
    run.answer()
    run.take(run.core.on_time(60.1))
    assert run.core.result is None


def test_without_released_rows_the_goal_stalls_and_says_what_is_awaited(run: Story) -> None:
    run.take(run.core.on_joints(joints(5), 0.0))
    run.take(run.core.on_time(0.6))
    assert run.core.phase == "waiting for layout mobile_pick_30d"
    run.take(run.core.on_time(5.1))
    result = run.core.result
    assert result is not None
    assert (result.outcome, result.kind) == ("failed", "stalled")
    assert result.detail == (
        "no rows released for 5.1 s, waiting for layout mobile_pick_30d at tick 5"
    )


def test_chunks_of_a_goal_share_a_trace_and_have_spans_of_their_own() -> None:
    plain = setup(lockstep=True)
    assert plain.trace_of(1) == bytes(24)
    traced = replace(plain, trace_id=bytes(range(16)))
    assert traced.trace_of(1) == traced.trace_of(1)
    assert traced.trace_of(1)[:16] == traced.trace_of(2)[:16] == bytes(range(16))
    assert traced.trace_of(1)[16:] != traced.trace_of(2)[16:]
    assert len(traced.trace_of(1)) == 24
