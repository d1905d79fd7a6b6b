"""``python -m bench.image_move``: whole pictures arrive, and a missed aim is said."""

from __future__ import annotations

import pytest

from bench.image_move.__main__ import misses, table, told
from bench.image_move.pictures import CASES, WARM_UP
from bench.image_move.ways import fairlead, floor

TWO = CASES[0]


@pytest.mark.processes
def test_every_tick_s_pictures_arrive_whole() -> None:
    for way in (floor, fairlead):
        latencies_us = way(TWO, WARM_UP + 5)
        assert len(latencies_us) == 5 and min(latencies_us) > 0


def test_ratios_are_of_medians_and_what_was_not_measured_is_said() -> None:
    found = {"fairlead": [90.0, 100.0, 400.0], "floor": [50.0, 50.0, 50.0], "zenoh": [300.0]}
    document = told(TWO, found, 3)
    assert (document["of_floor"], document["of_dora"]) == (2.0, None)
    assert misses([document]) == ["2 x 224 x 224: 2.00 of the floor, aim 1.35"]
    row = table([document]).splitlines()[-1]
    assert row == (
        "| 2 x 224 x 224 | 100 / 340 | 50 / 50 | 2.00 | not here | - | 300 / 300, 2 of 3 lost |"
    )
