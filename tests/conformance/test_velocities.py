"""What a joint's velocities add up to, whether its simulator or its hardware was late."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.motion_checks import travelled

PERIOD_S, SPEED = 0.02, 0.5
LATE_S = (0.02, 0.09, 0.02, 0.11)
"""How long each tick took."""


def states(moves_s: tuple[float, ...], scale: float = 1.0) -> list[Heard]:
    """A joint that moves at `SPEED` for so long in each tick; all of them came at once."""
    at = SPEED * np.cumsum([0.0, *moves_s])
    stamps = np.cumsum([0, *(round(1e9 * one) for one in LATE_S)])
    speed = np.array([scale * SPEED])
    return [
        Heard(tick, 1, int(stamp), np.array([place]), speed, np.zeros(1), ())
        for tick, (stamp, place) in enumerate(zip(stamps, at, strict=True))
    ]


@pytest.mark.parametrize("moves_s", [(PERIOD_S,) * len(LATE_S), LATE_S], ids=["sim", "hardware"])
def test_late_ticks_and_states_that_come_at_once_are_not_taken_for_another_unit(
    moves_s: tuple[float, ...],
) -> None:
    went = SPEED * sum(moves_s)
    assert travelled(states(moves_s), 0, PERIOD_S) == pytest.approx(went)


@pytest.mark.parametrize("scale", [PERIOD_S, 180.0 / np.pi], ids=["per tick", "degrees"])
@pytest.mark.parametrize("moves_s", [(PERIOD_S,) * len(LATE_S), LATE_S], ids=["sim", "hardware"])
def test_another_unit_stays_one(moves_s: tuple[float, ...], scale: float) -> None:
    share = travelled(states(moves_s, scale), 0, PERIOD_S) / (SPEED * sum(moves_s))
    assert not 0.5 <= share <= 2.0
