"""Realtime stories: when a goal may begin, what its policy is told, when layouts stop coming."""

from __future__ import annotations

import pytest

from fairlead.messages import HELD, Acted, Outcome
from fairlead.policy import Executed, Judged
from tests.runner.scripted_robot import EXECUTED, NO_ROW, Story, joints, layout, story, task


@pytest.fixture
def run() -> Story:
    return story(lockstep=False)


def test_layouts_that_stop_coming_end_the_goal_within_a_second(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)
    for tick in range(11, 26):
        run.take(run.core.on_joints(joints(tick), 0.0))
        assert run.core.result is None, "0.75 s at 20 Hz"
    run.take(run.core.on_joints(joints(26), 0.0))
    assert run.core.result is not None
    assert (run.core.result.outcome, run.core.result.kind, run.core.result.detail) == (
        "failed", "layout_missing",
        "no layout from the state_assembler for 16 ticks, at tick 26",
    )  # fmt: skip


def test_before_the_first_layout_and_in_lockstep_the_stall_timeout_decides() -> None:
    for run in (story(lockstep=False), story(lockstep=True)):
        if run.core.setup.lockstep:
            run.tick(10)
        for tick in range(11, 60):
            run.take(run.core.on_joints(joints(tick), 0.0))
        assert run.core.result is None


def test_nothing_is_observed_before_the_task_is_known_so_a_solved_scene_is_no_success(
    run: Story,
) -> None:
    run.take(run.core.on_joints(joints(10), 0.0))
    run.take(run.core.on_layout(layout(10), 0.0))
    assert run.asked == []
    run.take(run.core.on_task(task(10, success=True), 0.0))
    assert run.asked == []
    assert run.core.result is not None
    assert (run.core.result.outcome, run.core.result.kind) == ("failed", "already_solved")


@pytest.mark.parametrize("lockstep", [False, True])
def test_nothing_is_observed_while_rows_of_the_claim_before_act(lockstep: bool) -> None:
    run = story(lockstep=lockstep)
    run.tick(10, acted=EXECUTED)
    run.tick(10, acted=EXECUTED)
    assert run.asked == []
    run.take(run.core.on_time(1.0))
    assert run.core.phase == "waiting for its parts to hold"
    run.tick(11, acted=HELD)
    assert run.seen_ticks() == [11]


def test_a_policy_is_told_what_acted_and_what_the_gate_said(run: Story) -> None:
    run.tick(10)
    first = run.asked[0].observation
    assert first.judged is None
    assert set(first.executed) == {"arm", "gripper", "base", "composite"}
    assert set(first.executed.values()) == {Executed("starting", None)}
    run.answer()
    run.judge(first=11)
    for tick in range(11, 16):
        run.tick(tick, acted=EXECUTED)  # rows of verdict 1
    second = run.asked[1].observation
    assert second.tick == 15
    assert set(second.executed.values()) == {Executed("", 10)}
    assert second.judged == Judged(10, "released", "", "", 17)
    run.answer()
    run.judge(Outcome.REFUSED)
    run.tick(16, acted=NO_ROW)
    third = run.asked[2].observation
    assert set(third.executed.values()) == {Executed("no_row", None)}
    assert third.judged is not None
    assert (third.judged.answer_tick, third.judged.outcome, third.judged.code) == (
        15, "refused", "G020",
    )  # fmt: skip
    assert third.judged.text.startswith("G020 limit: chunk 2 refused at row 2, arm linear: 5")


def test_where_the_robot_s_report_or_a_verdict_is_lost_nothing_is_made_up(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)
    unknown = Acted(hold=0, verdict_id=99, row=0)
    for tick in range(11, 17):
        run.tick(tick, acted=unknown)
    assert set(run.asked[1].observation.executed.values()) == {Executed("", None)}
    run.answer()
    run.judge(first=17)
    run.take(run.core.on_joints(joints(23), 0.0))
    run.take(run.core.on_layout(layout(22), 0.0))
    assert run.asked[2].observation.executed == {}


def test_a_layout_that_overtakes_its_joint_state_waits_for_it(run: Story) -> None:
    run.tick(10)
    run.answer()
    run.judge(first=11)
    run.take(run.core.on_joints(joints(16), 0.0))
    run.take(run.core.on_layout(layout(17), 0.0))
    assert run.seen_ticks() == [10]
    run.take(run.core.on_joints(joints(17), 0.0))
    assert run.seen_ticks() == [10, 17]


@pytest.mark.parametrize("lockstep", [False, True])
def test_of_a_claim_that_was_handed_over_the_rows_before_may_act_on(lockstep: bool) -> None:
    run = story(lockstep=lockstep, handed_over=True)
    run.tick(10, acted=EXECUTED)
    assert [asked.observation.tick for asked in run.asked] == [10]
