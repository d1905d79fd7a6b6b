"""A few rows of the campaign in every test run; ``make faults`` runs them all."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from bench.faults.campaign import Campaign
from bench.faults.frame_faults import MANY_VARIABLE
from bench.faults.row import Row
from bench.faults.table import ROWS
from bench.faults.timer_process import TimerProcess

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SHORT = (1, 2, *range(4, 10), 16, 17, *range(19, 25), 27, 30, 34, 38, *range(43, 50))
"""Those that need no more than one light robot, one gate, or one arm, once each."""
ORDERS, ORDER_SAMPLES = 41, 2
FEWER_FRAMES = 20_000
LONG = {48}
"""Left to CI: with two arms it takes the longest."""
MATRIX = range(1, 50)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Campaign]:
    with TimerProcess() as timer, pytest.MonkeyPatch.context() as patch:
        patch.setenv(MANY_VARIABLE, str(FEWER_FRAMES))
        campaign = Campaign(tmp_path_factory.mktemp("faults"), timer, print)
        yield campaign
        campaign.close()


def in_order_of_stages() -> list[Any]:
    """So that each stage opens once."""
    chosen = [row for row in ROWS if row.number in SHORT and row.stage != "cameras"]
    return [
        pytest.param(row, marks=[pytest.mark.thorough] if row.number in LONG else [])
        for row in sorted(chosen, key=lambda row: row.stage)
    ]


@pytest.mark.parametrize("row", in_order_of_stages(), ids=lambda row: f"{row.number}-{row.fault}")
def test_a_fault_has_its_outcome_within_its_bound(campaign: Campaign, row: Row) -> None:
    result = campaign.run(row, injections=1)
    print(result.entry())
    assert result.passed, result.failures


@pytest.mark.thorough
def test_a_goal_moves_the_robot_after_a_sample_of_start_orders(campaign: Campaign) -> None:
    [row] = [row for row in ROWS if row.number == ORDERS and row.stage == "orders"]
    result = campaign.run(row, injections=ORDER_SAMPLES)
    assert result.passed, result.failures


def test_each_row_of_the_matrix_is_run() -> None:
    assert {row.number for row in ROWS} == set(MATRIX)
