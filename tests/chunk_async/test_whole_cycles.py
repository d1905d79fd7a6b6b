"""Which ticks of a run count, and what an answer took."""

from __future__ import annotations

import pytest

from bench.chunk_async.measured import Answer, latencies_of, whole_cycles


def test_cycles_count_from_where_an_answer_begins_to_act_to_where_the_last_does() -> None:
    in_force = [3, 3, None, 4, 4, None, None, 5, 5, 6, None]
    assert in_force[whole_cycles(in_force)] == [4, 4, None, None, 5, 5]


def test_latencies_are_those_of_the_answers_as_they_were() -> None:
    answers = [Answer(20, 0.2, 1.0, 1.4), Answer(28, 0.6, 1.41, 1.91)]
    assert latencies_of(answers) == pytest.approx([8.0, 10.0])
