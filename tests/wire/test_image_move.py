"""``python -m bench.image_move``: whole pictures arrive, and a missed aim is said."""

from __future__ import annotations

import subprocess
import sys

import pytest

from bench.image_move.__main__ import misses, table, told
from bench.image_move.pictures import CASES

TWO = CASES[0]


MOVE = """
from bench.image_move.pictures import CASES, WARM_UP
from bench.image_move.ways import fairlead, floor
print(*(len(way(CASES[0], WARM_UP + 5)) for way in (floor, fairlead)))
"""


@pytest.mark.processes
def test_every_tick_s_pictures_arrive_whole() -> None:
    """In a process of its own: the ends are forked, which the sessions of other tests forbid."""
    done = subprocess.run([sys.executable, "-c", MOVE], stdout=subprocess.PIPE, timeout=120)
    # Zenoh writes there too: a user who may lock 8 MB of memory is told that its pool was not made.
    assert done.stdout.split()[-2:] == [b"5", b"5"]


def test_ratios_are_of_medians_and_what_was_not_measured_is_said() -> None:
    found = {"fairlead": [90.0, 100.0, 400.0], "floor": [50.0]}
    document = told(TWO, found, 3)
    assert (document["of_floor"], document["of_dora"]) == (2.0, None)
    assert misses([document]) == ["2 x 224 x 224: 2.00 of the floor, aim 1.35"]
    row = table([document]).splitlines()[-1]
    assert row == "| 2 x 224 x 224 | 100, 340 | 50, 50, 2 of 3 lost; 2.00 | not here |"
