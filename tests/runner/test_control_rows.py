"""A policy slower than the robot: what each control period gets of its rows."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from fairlead.messages import ActionPart, floats, pack_floats
from fairlead.modes import ControlMode
from fairlead.skill.limit_overrides import limit_problems
from fairlead.skill.manifest import Between
from fairlead_skill_runner.control_rows import control_rows
from tests.runner.scripted_robot import ROBOT, SKILL, rows, story

N_DOF = 2


def spread(
    mode: ControlMode, values: npt.ArrayLike, periods: int, between: Between, most: int = 99
) -> list[list[float]]:
    part = ActionPart(part=0, mode=mode, frame_id="", values=pack_floats(values), active=(0, 1))
    (made,) = control_rows([part], [mode.width(N_DOF)], periods, between, most)
    width = mode.width(N_DOF)
    return [list(map(float, row)) for row in floats(made.values, width)]


def test_held_rows_are_repeated_by_index() -> None:
    made = spread(ControlMode.JOINT_POSITION, [[0.0, 1.0], [0.4, 2.0]], 2, "hold")
    assert made == [[0.0, 1.0], [0.0, 1.0], [0.4, 2.0], [0.4, 2.0]]


def test_positions_go_evenly_to_the_next_row_and_hold_at_the_last() -> None:
    made = spread(ControlMode.JOINT_POSITION, [[0.0, 1.0], [0.4, 2.0]], 4, "linear")
    assert [row[0] for row in made] == pytest.approx([0.0, 0.1, 0.2, 0.3] + [0.4] * 4)
    assert [row[1] for row in made] == pytest.approx([1.0, 1.25, 1.5, 1.75] + [2.0] * 4)


@pytest.mark.parametrize(
    "mode",
    [ControlMode.JOINT_VELOCITY, ControlMode.BODY_TWIST, ControlMode.CARTESIAN_TWIST,
     ControlMode.GRIPPER_POSITION, ControlMode.GRIPPER_BINARY, ControlMode.COMPOSITE_MODE],
)  # fmt: skip
def test_velocities_grippers_and_switches_are_held_also_with_linear(mode: ControlMode) -> None:
    values = np.arange(2.0)[:, None] * np.ones(mode.width(N_DOF))
    assert spread(mode, values, 3, "linear") == spread(mode, values, 3, "hold")
    assert spread(mode, values, 3, "hold") == [list(row) for row in np.repeat(values, 3, axis=0)]


@pytest.mark.parametrize("between", ["hold", "linear"])
def test_a_delta_is_divided_so_that_the_step_is_the_policys(between: Between) -> None:
    made = spread(ControlMode.CARTESIAN_DELTA, [[0.04, 0, 0, 0, 0, 0.2]], 4, between)
    assert made == [[0.01, 0, 0, 0, 0, 0.05]] * 4


def test_a_pose_turns_about_one_axis_the_short_way_round() -> None:
    def turned(angle: float, sign: float = 1.0) -> list[float]:
        return [0.0, 0.0, sign * math.sin(angle / 2), sign * math.cos(angle / 2)]

    first, second = [1.0, 0, 0, *turned(0.0)], [2.0, 0, 0, *turned(0.4, sign=-1.0)]
    made = spread(ControlMode.CARTESIAN_POSE, [first, second], 2, "linear")
    assert made[0] == pytest.approx(first)
    assert made[1] == pytest.approx([1.5, 0, 0, *turned(0.2)])
    assert made[2] == made[3] == pytest.approx(second)


def test_no_more_rows_are_made_than_are_to_be_executed_and_the_next_row_still_counts() -> None:
    values = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]
    made = spread(ControlMode.JOINT_POSITION, values, 2, "linear", most=4)
    assert [row[0] for row in made] == [0.0, 0.5, 1.0, 1.5]


def test_at_the_robots_own_rate_nothing_is_changed() -> None:
    values = [[0.1, -0.0], [0.3, 1e-300]]
    assert spread(ControlMode.JOINT_POSITION, values, 1, "linear") == values


def test_a_chunk_of_a_slow_policy_is_as_long_as_its_rows_last() -> None:
    run = story(lockstep=True, periods=2)
    run.tick(7)
    run.answer(rows(horizon=16))
    assert run.chunk.horizon == 2 * SKILL.execute_steps
    assert run.chunk.start_tick == 7


@pytest.mark.parametrize(
    ("rate_hz", "periods"), [(20.0, 1), (10.0, 2), (20 / 3, 3), (6.6666667, 3), (4.0, 5)]
)
def test_a_whole_fraction_of_the_robots_rate_is_taken(rate_hz: float, periods: int) -> None:
    skill = SKILL.model_copy(update={"rate_hz": rate_hz})
    assert skill.control_periods(ROBOT.tick_period_ns) == periods
    assert limit_problems(skill, ROBOT, "sim") == []


@pytest.mark.parametrize("rate_hz", [15.0, 19.9, 40.0, 3.0])
def test_another_rate_is_not(rate_hz: float) -> None:
    skill = SKILL.model_copy(update={"rate_hz": rate_hz})
    assert skill.control_periods(ROBOT.tick_period_ns) is None
