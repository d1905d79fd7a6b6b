"""Where an answer finds its joints holding: it begins where they are, and no faster than it is."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead_skill_runner.seam import Seam, held_rows
from tests.runner.seam_parts import BLEND, part


def test_joints_that_hold_lead_over_from_where_they_are_for_a_late_answer() -> None:
    new = part(ControlMode.JOINT_POSITION, [[6.0, 0.0]] * 8)
    new = msgspec.structs.replace(new, active=(0,))
    held = held_rows([new], np.array([2.0, 3.0]), 6)
    (made,) = Seam(held, 6, BLEND).blended([new], [2], 4)
    assert floats(made.values, 2).tolist() == [
        [2.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0], [5.0, 0.0],
        [6.0, 0.0],
    ]  # fmt: skip


def test_joints_that_hold_begin_with_the_nearest_row_and_catch_up_only_on_the_way_there() -> None:
    """No step is much longer than the answer's: 0.1 a tick, from 0.05 before its first row."""
    arm = part(ControlMode.JOINT_POSITION, [[0.1 * row, 0.0] for row in range(10)])
    arm = msgspec.structs.replace(arm, active=(0,))
    jaw = part(ControlMode.GRIPPER_BINARY, [[0.0]] * 3 + [[1.0]] * 7, index=1)
    held = held_rows([arm, jaw], np.array([-0.05, 3.0]), 6)
    moved, closed = Seam(held, 6, BLEND).blended([arm, jaw], [2, 1], 4)
    first = -0.05 + 0.05 / (BLEND + 1)
    steps = [0.1 + 0.05 / (BLEND + 1)] * BLEND + [0.1] * 2
    ways = [-0.05] * 4 + [first, *(first + np.cumsum(steps))][:6]
    assert floats(moved.values, 2)[:, 0] == pytest.approx(np.array(ways))
    assert floats(closed.values, 1)[:, 0].tolist() == [0.0] * 7 + [1.0] * 3, "as much later"


def test_joints_that_moved_on_before_they_held_do_not_go_back() -> None:
    arm = part(ControlMode.JOINT_POSITION, [[0.1 * row, 0.0] for row in range(10)])
    arm = msgspec.structs.replace(arm, active=(0,))
    held = held_rows([arm], np.array([0.21, 0.0]), 6)
    (moved,) = Seam(held, 6, BLEND).blended([arm], [2], 4)
    made = floats(moved.values, 2)[:, 0]
    assert made[:4].tolist() == [0.21] * 4
    assert np.all(np.diff(made[4:]) > 0.09)
    assert made[-1] == pytest.approx(0.7), "two rows later, as it was to be done"


def test_a_part_that_stands_still_lets_the_others_go_on_where_they_are() -> None:
    arm = part(ControlMode.JOINT_POSITION, [[0.02 * row, 0.0] for row in range(15)])
    arm = msgspec.structs.replace(arm, active=(0,))
    jaw = part(ControlMode.JOINT_POSITION, [[0.0, 0.7]] * 15, index=1)
    jaw = msgspec.structs.replace(jaw, active=(1,))
    held = held_rows([arm, jaw], np.array([0.12, 0.7]), 12)
    moved, still = Seam(held, 12, BLEND).blended([arm, jaw], [2, 2], 4)
    goes_on = [0.12, 0.12, 0.14, 0.16, 0.18, 0.2]
    assert floats(moved.values, 2)[9:, 0] == pytest.approx(np.array(goes_on))
    assert still == jaw


def test_on_the_way_from_a_hold_no_joint_gets_further_than_the_answer_or_the_hold() -> None:
    arm = part(ControlMode.JOINT_POSITION, [[min(1.0, 0.9 + 0.02 * k), 0.0] for k in range(12)])
    arm = msgspec.structs.replace(arm, active=(0,))
    held = held_rows([arm], np.array([0.99, 0.0]), 4)
    (moved,) = Seam(held, 4, 8).blended([arm], [2], 4)
    made = floats(moved.values, 2)[:, 0]
    assert made.max() == 1.0
    assert made[-1] == 1.0


def test_where_an_answer_has_motions_too_no_row_comes_later() -> None:
    arm = part(ControlMode.JOINT_POSITION, [[0.1 * row, 0.0] for row in range(10)])
    base = part(ControlMode.BODY_TWIST, np.ones((10, 6)), index=1)
    held = held_rows([arm, base], np.array([0.0, 0.0]), 6)
    moved, driven = Seam(held, 6, BLEND).blended([arm, base], [2, 6], 4)
    assert driven == base
    assert floats(moved.values, 2)[-1, 0] == pytest.approx(0.9)


def test_motions_begin_after_a_hold_as_the_answer_says() -> None:
    new = part(ControlMode.CARTESIAN_DELTA, np.ones((8, 6)))
    held = held_rows([new], np.array([2.0, 3.0]), 6)
    assert Seam(held, 6, BLEND).blended([new], [6], 4) == (new,)


def test_no_row_that_is_not_finite_is_left_out_where_rows_come_later() -> None:
    """The last rows of an answer that comes later are not sent: the gate is to see them all."""
    arm = part(ControlMode.JOINT_POSITION, [[0.1 * row, 0.0] for row in range(9)] + [[np.nan, 0.0]])
    arm = msgspec.structs.replace(arm, active=(0,))
    jaw = part(ControlMode.GRIPPER_BINARY, [[1.0]] * 9 + [[np.inf]], index=1)
    held = held_rows([arm, jaw], np.array([0.0, 0.0]), 6)
    moved, closed = Seam(held, 6, BLEND).blended([arm, jaw], [2, 1], 4)
    assert np.isnan(floats(moved.values, 2)[-1, 0])
    assert floats(closed.values, 1)[-1, 0] == np.inf
