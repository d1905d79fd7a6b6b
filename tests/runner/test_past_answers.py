"""What a policy is told of its own newest answers: rows that acted, were refused, will act."""

from __future__ import annotations

import numpy as np

from fairlead.messages import Acted, Hold, Outcome
from fairlead.policy import Executed, Judged, Observation, PastAnswer
from fairlead_skill_runner.gate_feedback import MAX_ANSWERS
from fairlead_skill_runner.policy_wire import Infer, decode_request, encode
from tests.runner.scripted_robot import EXECUTED, NO_ROW, Story, rows, story

ROWS = rows()


def told(run: Story, tick: int, acted: Acted = EXECUTED) -> Observation:
    """What the policy sees at a tick, whether it is asked then or not."""
    run.tick(tick, acted=acted)
    empty = Observation(tick, np.zeros(30), "")
    return run.core._feedback.added_to(empty, run.core._schedule.delay_ticks)


def marks(past: PastAnswer) -> str:
    """A letter a row: acted, refused, t for to act, - for none of these."""
    letters = []
    for acted, refused, to_act in zip(past.acted, past.refused, past.to_act, strict=True):
        assert acted + refused + to_act <= 1 or (acted and to_act)
        letters.append("a" if acted else "r" if refused else "t" if to_act else "-")
    return "".join(letters)


def begun(**changes: object) -> Story:
    run = story(lockstep=False, **changes)
    run.tick(10)
    run.answer(ROWS)
    return run


def test_rows_wait_act_or_come_too_late() -> None:
    run = begun()
    [past] = told(run, 11, NO_ROW).answers
    assert (past.tick, past.periods, past.outcome, marks(past)) == (10, 1, "", "-" * 8)
    np.testing.assert_array_equal(past.rows, ROWS)
    run.judge(first=12)
    seen = told(run, 12, NO_ROW)
    assert (seen.answers[0].outcome, marks(seen.answers[0])) == ("released", "--tttttt")
    assert seen.delay_ticks == 2
    seen = told(run, 14)
    assert marks(seen.answers[0]) == "---atttt", "the state of tick 13 was lost, and is not made up"
    np.testing.assert_array_equal(seen.rows_to_act(), ROWS[4:])


def test_a_refused_answer_leaves_the_rows_before_it_and_has_none_to_act() -> None:
    run = begun()
    run.judge(first=11)
    for tick in range(11, 16):
        run.tick(tick, acted=EXECUTED if tick > 11 else NO_ROW)
    assert run.seen_ticks() == [10, 15]
    run.answer(-ROWS)
    run.judge(Outcome.REFUSED)
    first, second = told(run, 16).answers
    assert (marks(first), marks(second)) == ("-aaaaatt", "rrrrrrrr")
    np.testing.assert_array_equal(told(run, 16).rows_to_act(), ROWS[6:])


def test_of_a_truncated_answer_only_the_first_rows_will_act() -> None:
    run = begun()
    run.judge(Outcome.TRUNCATED, first=11, last=13)
    assert marks(told(run, 11, NO_ROW).answers[0]) == "-tttrrrr"


def test_in_lockstep_rows_that_were_not_proposed_are_not_called_refused() -> None:
    run = story(lockstep=True)
    run.tick(10)
    run.answer(rows(horizon=12))
    run.judge(Outcome.TRUNCATED, first=10, last=13)
    assert marks(told(run, 11).answers[0]) == "atttrrrr----"


def test_a_newer_answer_replaces_the_rows_of_the_older() -> None:
    run = begun()
    run.judge(first=11)
    for tick in range(11, 16):
        run.tick(tick, acted=EXECUTED if tick > 11 else NO_ROW)
    run.answer(-ROWS)
    run.judge(first=16)
    first, second = told(run, 16).answers
    assert (marks(first), marks(second)) == ("-aaaaa--", "-ttttttt")


def test_rows_that_are_judged_again_and_refused_will_not_act() -> None:
    run = begun()
    run.judge(first=11)
    run.tick(11, acted=NO_ROW)
    run.judge(Outcome.REFUSED)
    assert marks(told(run, 12).answers[0]) == "rarrrrrr"


def test_rows_of_a_slower_policy_last_several_periods() -> None:
    run = begun(periods=2)
    run.judge(first=11, last=25)
    seen = told(run, 14)
    assert seen.answers[0].periods == 2
    assert marks(seen.answers[0]) == "-atttttt"
    np.testing.assert_array_equal(seen.rows_to_act(), ROWS[2:])


def test_only_the_newest_answers_are_remembered() -> None:
    run = begun()
    for tick in range(11, 11 + 20 * MAX_ANSWERS):
        if not run.core._chunks.answered:
            run.judge(Outcome.REFUSED)
        run.tick(tick, acted=NO_ROW)
        if run.core._asked:
            run.answer(ROWS)
    past = told(run, 11 + 20 * MAX_ANSWERS, NO_ROW).answers
    assert len(past) == MAX_ANSWERS
    assert [one.tick for one in past] == sorted(one.tick for one in past)


def test_rows_that_act_for_long_are_told_whatever_was_refused_since() -> None:
    """A policy that continues its rows would begin anew where it is told that none will act."""
    run = begun()
    run.judge(first=11)
    for tick in range(11, 17):
        run.core._feedback.on_answer(tick, ROWS, 8)
    seen = told(run, 12)
    assert len(seen.answers) == MAX_ANSWERS
    assert seen.answers[0].tick == 10
    assert len(seen.rows_to_act()) > 0


def test_the_worker_gets_all_of_it_bit_for_bit() -> None:
    rng = np.random.default_rng(1)
    frames = rng.integers(0, 256, (4, 6, 5, 3)).astype(np.uint8)
    plain = rng.integers(0, 256, (6, 5, 3)).astype(np.uint8)
    masks = [rng.integers(0, 2, 8).astype(bool) for _ in range(3)]
    past = PastAnswer(7, ROWS, 2, "truncated", *masks)
    sent = Observation(
        9, rng.normal(size=16), "go", {"a": frames[-1], "b": plain},
        {"arm": Executed("", 7)}, Judged(7, "truncated", "G020", "why", 8),
        {"a": frames}, (past,), 3, periods=2,
    )  # fmt: skip
    request = decode_request(encode(Infer.of(sent)))
    assert isinstance(request, Infer)
    got = request.observation()
    assert list(got.images) == ["a", "b"]
    assert list(got.frames) == ["a"]
    for name in sent.images:
        np.testing.assert_array_equal(got.images[name], sent.images[name])
        np.testing.assert_array_equal(got.frames_of(name), sent.frames_of(name))
    [back] = got.answers
    assert back.rows.tobytes() == ROWS.tobytes()
    assert (back.tick, back.periods, back.outcome, marks(back)) == (7, 2, "truncated", marks(past))
    assert (got.executed, got.judged) == (sent.executed, sent.judged)
    assert (got.delay_ticks, got.periods) == (3, 2)


def test_a_part_that_held_did_not_let_a_row_act() -> None:
    run = begun()
    run.judge(first=11)
    held = Acted(hold=Hold.NOT_GRANTED, verdict_id=0, row=0)
    assert marks(told(run, 12, held).answers[0]) == "--tttttt"
