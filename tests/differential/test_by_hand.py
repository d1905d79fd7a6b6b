"""Rulings computed by hand: the reference can be wrong too, and both judges must agree here.

Numbers are those of robots/panda/gate.sim.json: joint 1 within 2.8973 rad, tolerance 0.05 rad,
2.175 rad/s, steps 0.055 rad and 0.75 rad/s; gripper 0 to 0.08 m.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from fairlead.messages import LimitOverride, Outcome
from tests.differential.comparison import readable, rulings
from tests.differential.gates import Pair
from tests.differential.plain import TICK, arm, case, gripper, moving, rest, speeds

pytestmark = pytest.mark.processes

RELEASED, TRUNCATED, REFUSED = Outcome.RELEASED, Outcome.TRUNCATED, Outcome.REFUSED
UPPER = 2.8973
OUTSIDE = still(TICK, rest(j1=UPPER + 0.3))
TIGHTER = (LimitOverride(part="arm", mode=1, name="velocity_limit", value=0.5),)

CASES: dict[str, tuple[Case, tuple[Outcome, int, int, int]]] = {
    # name: case, (outcome, code, row at fault, rows released)
    "a row where the robot stands": (case(arm(rest())), (RELEASED, 0, -1, 1)),
    "a step of 0.054 rad": (case(arm(rest(), rest(j1=0.054))), (RELEASED, 0, -1, 2)),
    "a step of 0.056 rad": (case(arm(rest(), rest(j1=0.056))), (TRUNCATED, 22, 1, 1)),
    "a start within step and tolerance": (case(arm(rest(j1=0.104))), (RELEASED, 0, -1, 1)),
    "a start beyond both": (case(arm(rest(j1=0.106))), (REFUSED, 21, 0, 0)),
    "a target beyond the bounds": (
        case(arm(rest(j1=UPPER), rest(j1=2.8974)), measured=still(TICK, rest(j1=UPPER))),
        (TRUNCATED, 20, 1, 1),
    ),
    "2.2 rad/s": (case(speeds([2.2]), measured=moving(2.1)), (REFUSED, 20, 0, 0)),
    "a velocity far from the measured one": (case(speeds([-0.7])), (RELEASED, 0, -1, 1)),
    "a velocity too far from it": (case(speeds([-0.76])), (REFUSED, 21, 0, 0)),
    "a velocity above the claim's own": (
        replace(case(speeds([0.5], [0.51])), overrides=TIGHTER),
        (TRUNCATED, 20, 1, 1),
    ),
    "outside, a target nearer": (
        case(arm(rest(j1=UPPER + 0.2)), measured=OUTSIDE),
        (RELEASED, 0, -1, 1),
    ),
    "outside, a target further": (
        case(arm(rest(j1=UPPER + 0.31)), measured=OUTSIDE),
        (REFUSED, 11, 0, 0),
    ),
    "outside, nearer and then further": (
        case(arm(rest(j1=UPPER + 0.2), rest(j1=UPPER + 0.25)), measured=OUTSIDE),
        (TRUNCATED, 11, 1, 1),
    ),
    "outside, only the gripper": (case(gripper(0.04), measured=OUTSIDE), (RELEASED, 0, -1, 1)),
    "outside, standing still": (case(speeds([0.0]), measured=OUTSIDE), (REFUSED, 11, 0, 0)),
    "a gripper wider than it opens": (case(gripper(0.081)), (REFUSED, 20, 0, 0)),
    "no number in the last row": (case(gripper(0.04, np.nan)), (REFUSED, 8, 1, 0)),
    "bad rows, but past ones": (
        case(arm(rest(j1=1.0), rest(j1=0.1)), start=TICK - 1),
        (RELEASED, 0, -1, 1),
    ),
    "all rows past": (case(gripper(0.04), start=TICK - 1), (REFUSED, 12, -1, 0)),
    "one bad part of two": (case(arm(rest()), gripper(0.1)), (REFUSED, 20, 0, 0)),
    "a part twice": (case(gripper(0.04), gripper(0.04)), (REFUSED, 9, -1, 0)),
}


@pytest.mark.parametrize("name", CASES)
def test_both_judges_say_what_was_computed_by_hand(panda: Pair, name: str) -> None:
    shown, (outcome, code, row, released) = CASES[name]
    (ruling,) = rulings(panda.file, shown)
    (answer,) = panda.answers(shown)
    verdict, fault = answer.verdict, ruling.fault

    assert (ruling.outcome, ruling.row_count) == (outcome, released)
    assert (fault.code if fault else 0, fault.row if fault else -1) == (code, row)
    assert (verdict.outcome, verdict.code, verdict.row) == (outcome, code, row)
    assert (answer.safe.horizon if answer.safe else 0) == released


LAST = 2**64 - 2
ONCE_DIFFERENT: dict[str, tuple[Case, tuple[int, float]]] = {
    # name: case, (code, margin)
    "a row for the last tick that can end": (
        replace(
            case(gripper(0.04)),
            measured=still(LAST, rest()),
            chunk=Chunk(LAST, 1, (gripper(0.04),)),
        ),
        (0, 0.0),
    ),
    "below a lower bound and away": (
        case(speeds([0.0, 0.0, 0.0, -0.1]), measured=still(TICK, rest(j4=-3.5))),
        (11, -0.1),
    ),
    "the smallest velocity back": (case(speeds([-5e-324]), measured=OUTSIDE), (0, 0.0)),
    "a number below -1e6": (case(gripper(-2e6)), (8, 1e6 - 2e6)),
    "no number beside a mode without a checker": (
        case(PartRows(0, 3, np.zeros((1, 1))), gripper(np.nan)),
        (8, np.nan),
    ),
}


@pytest.mark.parametrize("name", ONCE_DIFFERENT)
def test_both_judges_give_the_same_code_and_margin(panda: Pair, name: str) -> None:
    shown, (code, margin) = ONCE_DIFFERENT[name]
    found = panda.differences(shown)
    assert not found, readable(shown, found)
    (answer,) = panda.answers(shown)
    assert answer.verdict.code == code
    np.testing.assert_equal(answer.verdict.margin, margin)


GENTLE = Case("panda", "realtime", still(TICK + 1, rest()), Chunk(TICK + 2, 1, (speeds([0.5]),)))


@pytest.mark.parametrize(
    ("last", "now", "code", "limit"),
    [
        (0.5, 1.2, 0, 0.0),
        (0.5, 1.26, 23, 0.75),  # a step of 0.76 rad/s from a row that is not measured yet
        (0.5, -0.26, 23, 0.75),
    ],
)
def test_a_seam_in_realtime_has_its_own_code(
    panda: Pair, last: float, now: float, code: int, limit: float
) -> None:
    earlier = Chunk(TICK + 1, 2, (speeds([last], [last]),))
    chunk = Chunk(TICK + 2, 1, (speeds([now]),))
    shown = replace(GENTLE, first=still(TICK, rest()), earlier=earlier, chunk=chunk)
    found = panda.differences(shown)
    assert not found, readable(shown, found)
    verdict = panda.answers(shown)[-1].verdict
    assert (verdict.code, verdict.limit) == (code, limit)
