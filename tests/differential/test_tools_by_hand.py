"""Tools and hands of `dual_panda`, with numbers computed by hand.

The left arm bends elbow and wrist by a right angle each: its tool points down, 0.5545 m in front
of its base (0.0825 + 0.384 + 0.088) and 0.5211 m above it (0.333 + 0.316 + 0.0825 - 0.107 -
0.1034). The base stands at (0, 0.25, 0.6) m, turned by 0.4 rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Measured, PartRows
from fairlead.messages import FloatArray, Outcome
from tests.differential.comparison import rulings
from tests.differential.gates import Pair, pair_of

pytestmark = pytest.mark.processes

TICK, REACH, TURN = 100, 0.5545, 0.4
LEFT_ARM, LEFT_GRIPPER, _, RIGHT_HAND = range(4)
POSE, TWIST, BINARY, HAND = 4, 6, 9, 11
JOINTS, PASSIVE = 21, 2
ELBOW, WRIST = 3, 5
TOOL = np.array([REACH * math.cos(TURN), 0.25 + REACH * math.sin(TURN), 1.1211])
HALF = (TURN + math.pi / 4.0) / 2.0
POINTING_DOWN = np.array([math.cos(HALF), math.sin(HALF), 0.0, 0.0])
RELEASED, TRUNCATED, REFUSED = Outcome.RELEASED, Outcome.TRUNCATED, Outcome.REFUSED


@pytest.fixture(scope="module")
def dual() -> Iterator[Pair]:
    with pair_of("dual_panda") as found:
        yield found


def measured(turning: float = 0.0) -> Measured:
    """Left joint 1 turns [rad/s]; the rest stands still."""
    positions = np.zeros(JOINTS + PASSIVE)
    for first in (0, 8):
        positions[first + ELBOW], positions[first + WRIST] = -math.pi / 2.0, math.pi / 2.0
    velocities, efforts = np.zeros(JOINTS + PASSIVE), np.zeros(JOINTS + PASSIVE)
    velocities[0] = turning
    return Measured(TICK, positions, velocities, efforts)


def shown(rows: PartRows, state: Measured | None = None) -> Case:
    chunk = Chunk(TICK, len(rows.values), (rows,))
    return Case("dual_panda", "lockstep", state or measured(), chunk)


def pose(*places: FloatArray, quaternion: FloatArray = POINTING_DOWN) -> PartRows:
    values = np.array([np.concatenate([place, quaternion]) for place in places])
    return PartRows(LEFT_ARM, POSE, values, "base_link")


def twist(*values: float) -> PartRows:
    return PartRows(LEFT_ARM, TWIST, np.array([values]), "base_link")


def joint(part: int, mode: int, index: int, *values: float) -> PartRows:
    rows = np.zeros((len(values), JOINTS))
    rows[:, index] = values
    return PartRows(part, mode, rows, active=(index,))


def switch(*values: float) -> PartRows:
    return PartRows(LEFT_GRIPPER, BINARY, np.array([[value] for value in values]))


AHEAD = np.array([0.02, 0.0, 0.0])
TURNED = np.array([math.cos(HALF + 0.1), math.sin(HALF + 0.1), 0.0, 0.0])

CASES: dict[str, tuple[Case, tuple[Outcome, int, str, float]]] = {
    # name: case, (outcome, code, axis, value)
    "a pose where the tool is": (shown(pose(TOOL)), (RELEASED, 0, "", 0.0)),
    "the same turn, its other quaternion": (
        shown(pose(TOOL, quaternion=-POINTING_DOWN)),
        (RELEASED, 0, "", 0.0),
    ),
    "0.06 m ahead": (shown(pose(TOOL + 3.0 * AHEAD)), (REFUSED, 21, "linear", 0.06)),
    "0.02 m, then 0.06 m further": (
        shown(pose(TOOL + AHEAD, TOOL + 4.0 * AHEAD)),
        (TRUNCATED, 22, "linear", 0.06),
    ),
    "turned by 0.2 rad": (shown(pose(TOOL, quaternion=TURNED)), (REFUSED, 21, "angular", 0.2)),
    "a quaternion of norm 1.1": (
        shown(pose(TOOL, quaternion=1.1 * POINTING_DOWN)),
        (REFUSED, 20, "quaternion norm", 1.1),
    ),
    "behind the box": (
        shown(pose(np.array([0.1, 0.5, 1.1]))),
        (REFUSED, 20, "x", 0.1),
    ),
    "rest, while the arm turns at 1 rad/s": (
        shown(twist(0, 0, 0, 0, 0, 0), measured(turning=1.0)),
        (RELEASED, 0, "", 0.0),
    ),
    "rest, while the arm turns at 1.2 rad/s": (
        shown(twist(0, 0, 0, 0, 0, 0), measured(turning=1.2)),
        (REFUSED, 21, "linear", 1.2 * REACH),
    ),
    "the twist that the arm has at 1.2 rad/s": (
        shown(
            twist(-1.2 * REACH * math.sin(TURN), 1.2 * REACH * math.cos(TURN), 0, 0, 0, 1.2),
            measured(turning=1.2),
        ),
        (RELEASED, 0, "", 0.0),
    ),
    "open, closed, open": (shown(switch(0.0, 1.0, 0.0)), (RELEASED, 0, "", 0.0)),
    "half open": (shown(switch(1.0, 0.5)), (TRUNCATED, 20, "closed", 0.5)),
    "a thumb by a step and its tolerance": (
        shown(joint(RIGHT_HAND, HAND, 15, 0.19)),
        (RELEASED, 0, "", 0.0),
    ),
    "a thumb by more": (
        shown(joint(RIGHT_HAND, HAND, 15, 0.21)),
        (REFUSED, 21, "right_thumb_joint1", 0.21),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_both_judges_say_what_was_computed_by_hand(dual: Pair, name: str) -> None:
    case, (outcome, code, axis, value) = CASES[name]
    (ruling,) = rulings(dual.file, case)
    (answer,) = dual.answers(case)
    verdict, fault = answer.verdict, ruling.fault

    assert (verdict.outcome, verdict.code, verdict.axis) == (outcome, code, axis)
    assert verdict.value == pytest.approx(value, abs=1e-9)
    assert ruling.outcome == outcome
    assert (fault.code if fault else 0, fault.axis if fault else "") == (code, axis)
    assert (fault.value if fault else 0.0) == pytest.approx(value, abs=1e-9)


def test_the_tool_is_where_a_ruler_says(dual: Pair) -> None:
    place, _ = dual.file.kinematics.pose(measured().positions, "left_tcp", "base_link")
    np.testing.assert_allclose(place, TOOL, atol=1e-9)
    place, _ = dual.file.kinematics.pose(measured().positions, "left_tcp", "left_link0")
    np.testing.assert_allclose(place, [REACH, 0.0, 0.5211], atol=1e-9)
