"""When a policy is asked again, by what its answers took before."""

from __future__ import annotations

import msgspec
import pytest

from fairlead.messages import Outcome
from fairlead_skill_runner.chunk_tracker import SentChunk
from fairlead_skill_runner.observation_schedule import REMEMBERED, ObservationSchedule
from tests.runner.scripted_robot import NO_ROW, Story, story, verdict

HORIZON = 16


@pytest.fixture
def schedule() -> ObservationSchedule:
    return ObservationSchedule(HORIZON)


def answer(schedule: ObservationSchedule, seq: int, delay: int) -> int:
    """An answer that took so many ticks; how many after its observation the next one is."""
    chunk = SentChunk(seq, 100 * seq, HORIZON, 100 * seq + delay - 1, b"")
    schedule.sent(chunk, chunk.sent_tick)
    return schedule.next_tick - chunk.obs_tick


def test_the_longest_of_the_last_delays_is_expected_again(schedule: ObservationSchedule) -> None:
    answer(schedule, 1, 2)
    assert answer(schedule, 2, 4) == HORIZON - 4 - 2
    assert [answer(schedule, 3 + n, 2) for n in range(REMEMBERED - 1)] == [10] * (REMEMBERED - 1)
    assert answer(schedule, 40, 2) == HORIZON - 2 - 2, "the long one is forgotten"


def test_a_cold_start_counts_only_until_there_is_a_second_answer(
    schedule: ObservationSchedule,
) -> None:
    assert answer(schedule, 1, 12) == HORIZON - 12 - 1
    assert schedule.delay_ticks == 12
    assert answer(schedule, 2, 3) == HORIZON - 3 - 2
    assert schedule.delay_ticks == 3


@pytest.mark.parametrize(("delay", "spare"), [(6, 2), (7, 2), (8, 1), (9, 1)])
def test_a_second_tick_is_spare_where_the_policy_need_not_hurry_for_it(
    schedule: ObservationSchedule, delay: int, spare: int
) -> None:
    answer(schedule, 1, delay)
    spacing = answer(schedule, 2, delay)
    assert spacing == HORIZON - delay - spare
    assert spacing >= delay or spare == 1


def test_rows_that_are_judged_again_are_no_longer_delay(schedule: ObservationSchedule) -> None:
    run = story(lockstep=False)
    run.tick(10)
    run.answer()
    chunk = SentChunk(1, 10, HORIZON, 10, b"")
    schedule.sent(chunk, 10)
    first = verdict(run.chunk, 1, Outcome.RELEASED, 12, 25)
    schedule.judged(chunk, first)
    assert schedule.delay_ticks == 2
    schedule.judged(chunk, msgspec.structs.replace(first, verdict_id=2, released_first=18))
    assert schedule.delay_ticks == 2


def test_a_goal_says_starved_from_the_first_tick_without_a_row_to_the_next_with_one() -> None:
    run: Story = story(lockstep=False)
    run.tick(10, acted=NO_ROW)
    assert run.core.phase == "running", "no rows have run yet"
    run.answer()
    run.judge(first=11)
    run.tick(11)
    assert run.core.phase == "running"
    run.tick(12, acted=NO_ROW)
    assert (run.core.phase, run.core.starved) == ("starved", 1)
    run.take(run.core.on_time(run.now_s + 0.1))
    assert run.core.phase == "starved"
    run.tick(13)
    assert (run.core.phase, run.core.starved) == ("running", 1)
