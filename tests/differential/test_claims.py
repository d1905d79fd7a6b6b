"""A claim's own limits: tighter ones are taken, looser ones are not, to the last bit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fairlead.messages import LimitOverride
from tests.differential.case import Case, Chunk, still
from tests.differential.claims import is_tighter, tightenable
from tests.differential.core_gate import CaseRefusedError
from tests.differential.gates import Pair


def is_taken(pair: Pair, override: LimitOverride) -> bool:
    state = still(100, np.zeros(len(pair.file.joints) + len(pair.file.passive)))
    case = Case(pair.robot, "lockstep", state, Chunk(100, 1, ()), overrides=(override,))
    pair.core.start("lockstep", state)
    try:
        pair.core.claim(case)
    except CaseRefusedError:
        return False
    return True


def test_a_claim_is_taken_exactly_where_its_limit_is_no_looser(pair: Pair) -> None:
    for index, part in enumerate(pair.file.parts):
        for mode in part.modes:
            for name, room in tightenable(pair.file, index, mode).items():
                ends = (room.lowest, room.highest)
                near = [math.nextafter(end, to) for end in ends for to in (-math.inf, math.inf)]
                for value in (*ends, *near, 0.0, -1.0, 1e9, math.nan, math.inf):
                    override = LimitOverride(part=part.name, mode=mode, name=name, value=value)
                    expected = is_tighter(room, value)
                    assert is_taken(pair, override) == expected, f"{override}, room {room}"


@pytest.mark.parametrize("name", ["source", "frames", "", "speed"])
def test_a_claim_that_names_what_is_no_limit_is_refused(pair: Pair, name: str) -> None:
    for part in pair.file.parts:
        for mode in part.modes:
            override = LimitOverride(part=part.name, mode=mode, name=name, value=1e-3)
            assert not is_taken(pair, override)
