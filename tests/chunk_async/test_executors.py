"""The theory of rows that run out, and the models of other executors, on numbers done by hand."""

from __future__ import annotations

import random

import pytest

from bench.chunk_async.executors import latest_wins, synchronous, theory

HORIZON = 16


@pytest.mark.parametrize("latency", [8.25, 9.5, 11.0, 13.75])
def test_the_theory_of_a_constant_latency_is_its_formula(latency: float) -> None:
    expected = min(1.0, (HORIZON - 1 - latency) / latency)
    assert theory([latency] * 400, HORIZON) == pytest.approx(expected, abs=0.005)


@pytest.mark.parametrize("latency", [1.0, 4.0, 7.0])
def test_short_latencies_let_no_row_run_out(latency: float) -> None:
    assert theory([latency] * 100, HORIZON) == 1.0


def test_latencies_longer_than_a_chunk_leave_no_row() -> None:
    assert theory([HORIZON + 1.0] * 20, HORIZON) == 0.0


def test_lost_messages_cost_rows() -> None:
    rng = random.Random(1)
    latencies = [rng.uniform(8.0, 12.0) for _ in range(400)]
    whole, lossy = (theory(latencies, HORIZON, lost) for lost in (0.0, 0.1))
    assert whole - lossy == pytest.approx(2 * 0.1 / 10.0, abs=0.005)


def test_a_synchronous_executor_stalls_for_each_answer() -> None:
    done = synchronous([3.2, 5.0], [0.1, 0.4], HORIZON)
    assert done.levels == [0.1] * HORIZON + [None] * 5 + [0.4] * HORIZON
    assert (done.stalls, done.largest_step) == (5, 0.0)


def test_the_latest_answer_replaces_rows_and_makes_its_whole_step_at_once() -> None:
    done = latest_wins([2.0, 3.0, 3.0], [0.1, 0.4, 0.2], HORIZON)
    # Asked at 0, there at 2; half is left at 8, the next is there at 11; half of that at 16.
    assert done.levels == [0.1] * 9 + [0.4] * 8 + [0.2] * 5
    assert done.stalls == 0
    assert done.largest_step == pytest.approx(0.3)


def test_a_queue_that_knows_no_latency_runs_empty_beyond_half_a_chunk() -> None:
    done = latest_wins([10.0] * 20, [0.1] * 20, HORIZON)
    assert done.stalls > 0
    assert latest_wins([7.5] * 20, [0.1] * 20, HORIZON).stalls == 0
