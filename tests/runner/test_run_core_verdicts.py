"""What a verdict changes, which verdicts count, and which chunk is sent again."""

from __future__ import annotations

import msgspec
import pytest

from fairlead.messages import Outcome
from tests.runner.scripted_robot import (
    Story,
    story,
    verdict,
)


@pytest.fixture
def run() -> Story:
    return story(lockstep=True)


def test_a_duplicate_verdict_and_one_of_another_claim_say_nothing(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge()
    run.verdicts = 0
    run.judge(Outcome.TRUNCATED, last=5)  # verdict id 1 again
    assert run.core.last_refusal == ""
    run.tick(6)
    assert run.seen_ticks() == [5]


def test_rows_judged_again_and_refused_are_no_longer_counted_on(run: Story) -> None:
    run.tick(5)
    run.answer()
    run.judge()
    run.tick(6)
    run.judge(Outcome.REFUSED)  # the gate judged what was left of chunk 1 once more
    assert run.seen_ticks() == [5, 6]


def test_a_released_tick_that_comes_again_has_the_chunk_sent_again(run: Story) -> None:
    """The row may have been judged again and refused, and that verdict been lost."""
    run.tick(5)
    run.answer()
    run.judge(last=12)
    run.tick(6)
    assert len(run.sent) == 1
    run.tick(6)
    assert len(run.sent) == 2
    assert run.sent[1] == run.sent[0]
    run.judge(Outcome.REFUSED)
    assert run.seen_ticks() == [5, 6]


@pytest.mark.parametrize("change", [{"session": 12}, {"epoch": 23}, {"claim_id": 34}])
def test_a_verdict_of_another_session_epoch_or_claim_is_ignored(
    run: Story, change: dict[str, int]
) -> None:
    run.tick(5)
    run.answer()
    other = msgspec.structs.replace(verdict(run.chunk, 1), **change)
    run.take(run.core.on_verdict(other, 0.0))
    assert run.core.queue_depth == 0


@pytest.mark.parametrize("code", [2, 3, 4, 5])
def test_the_refusal_of_an_injected_chunk_takes_no_released_row_away(run: Story, code: int) -> None:
    run.tick(5)
    run.answer()
    run.judge(last=12)
    injected = msgspec.structs.replace(verdict(run.chunk, 9, Outcome.REFUSED), code=code)
    run.take(run.core.on_verdict(injected, 0.0))
    assert (run.core.queue_depth, run.core.last_refusal) == (7, "")


def test_a_chunk_whose_number_an_injected_one_used_is_answered_by_its_refusal(run: Story) -> None:
    run.tick(5)
    run.answer()
    refused = msgspec.structs.replace(verdict(run.chunk, 1, Outcome.REFUSED), code=5)
    run.take(run.core.on_verdict(refused, 0.0))
    assert "G005" in run.core.last_refusal


def late(run: Story, value: float, code: int = 6) -> str:
    """The words on a refusal of an answer that took 0.3 s, over ticks 5 to 11."""
    run.tick(5)
    for tick in range(6, 12):
        run.tick(tick)
    run.now_s = 0.3
    run.answer()
    refused = msgspec.structs.replace(
        verdict(run.chunk, 1, Outcome.REFUSED), code=code, value=value, limit=10.0
    )
    run.take(run.core.on_verdict(refused, 0.3))
    return run.core.last_refusal


def test_a_chunk_that_a_slow_policy_made_too_old_says_so_with_the_time_it_has() -> None:
    text = late(story(lockstep=False), value=12.0)
    assert text.startswith("G006 ")
    assert text.endswith(
        "; the policy is slow: it answered after 0.30 s and has 0.20 s: age_max_ticks, 10 of "
        "50 ms, less the age of its inputs"
    )


@pytest.mark.parametrize(("value", "code"), [(12.0, 20), (0.0, 6), (10.0, 6)])
def test_other_refusals_say_nothing_of_slowness(value: float, code: int) -> None:
    assert "slow" not in late(story(lockstep=False), value, code)


def test_the_goal_s_result_has_the_words_too() -> None:
    run = story(lockstep=False, deadline_ticks=8)
    late(run, value=12.0)
    run.answer() if run.core._asked else None
    run.tick(14)
    assert run.core.result is not None
    assert "the last: G006 " in run.core.result.detail
    assert "the policy is slow: it answered after 0.30 s" in run.core.result.detail
