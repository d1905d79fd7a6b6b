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
