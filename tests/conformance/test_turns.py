"""Whether positions of a continuous joint count its turns, as far as a robot was seen to turn."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.robot.manifest import load_robot
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.identity_checks import turns
from fairlead_tools.conformance.row import Row

ROBOT = load_robot("kinova3")
JOINTS = len(ROBOT.measured_joint_names)
CONTINUOUS = [
    index
    for index, name in enumerate(ROBOT.measured_joint_names)
    if ROBOT.joint(name).type == "continuous"
]
FAR = np.linspace(3.0, 3.3, 4)
"""Across half a turn."""


def heard(ways: dict[int, np.ndarray]) -> list[Heard]:
    """States in which these joints go their way, and all others stay."""
    every = np.zeros((len(FAR), JOINTS))
    for index, way in ways.items():
        every[:, index] = way
    still = np.zeros(JOINTS)
    return [Heard(tick, 1, 1, now, still, still, ()) for tick, now in enumerate(every)]


def row_of(ways: dict[int, np.ndarray]) -> Row:
    (row,) = turns(ROBOT, heard(ways))
    return row


@pytest.mark.parametrize("way", [FAR, -FAR, FAR + 40.0], ids=["up", "down", "many turns"])
def test_joints_that_go_on_beyond_half_a_turn_pass(way: np.ndarray) -> None:
    assert row_of(dict.fromkeys(CONTINUOUS, way)).outcome == "pass"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_position_that_jumps_back_by_a_turn_fails_with_both_places(sign: float) -> None:
    wrapped = sign * np.where(np.pi < FAR, FAR - 2.0 * np.pi, FAR)
    row = row_of({CONTINUOUS[-1]: wrapped})
    name = ROBOT.measured_joint_names[CONTINUOUS[-1]]
    assert (row.outcome, row.got) == (
        "fail",
        f"{name}: {sign * 3.1:g} rad, then {wrapped[2]:.4g} rad",
    )


def test_joints_that_were_not_seen_that_far_are_not_said_to_count() -> None:
    row = row_of(dict.fromkeys(CONTINUOUS[1:], FAR))
    name = ROBOT.measured_joint_names[CONTINUOUS[0]]
    assert row.outcome == "not checked" and row.got.startswith(f"{name}: stayed within half a turn")


def test_a_robot_without_such_joints_has_no_row() -> None:
    assert list(turns(load_robot("panda"), heard({}))) == []
