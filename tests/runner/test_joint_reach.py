"""The joint-space policy that ships: smooth targets to one pose."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError, PolicyError
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Done, Executed, Observation
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.joint_reach import ACCELERATION_RAD, JointReachPolicy
from tests.runner.scripted_robot import SKILL as TWELVE_WIDE

SKILL = load_skill("panda-joint-reach")
SIX = load_skill("so101-reach")
OPTIONS = SKILL.policy.options
TARGET = np.array(OPTIONS["target_rad"], dtype=float)
START = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785])


def policy() -> JointReachPolicy:
    return JointReachPolicy.from_options(SKILL, OPTIONS)


def seen(tick: int, joints: FloatArray) -> Observation:
    return Observation(tick, np.concatenate([joints, [0.04, -0.04]]), "")


def rows_of(reaching: JointReachPolicy, observation: Observation) -> Actions:
    rows = reaching.infer(observation)
    assert isinstance(rows, np.ndarray)
    return rows


def test_rows_start_at_the_joints_end_at_the_target_and_never_leap() -> None:
    reaching, joints, targets = policy(), START, [START]
    for chunk in range(4):
        rows = rows_of(reaching, seen(1 + 8 * chunk, joints))
        assert rows.shape == (16, 8) and rows.dtype == np.float32
        targets += list(rows[:8, :7].astype(float))
        joints = targets[-3]  # the arm follows two ticks later
    steps = np.diff(targets, axis=0)
    assert np.abs(steps).max() <= 0.045 + 1e-6
    assert np.abs(np.diff(steps, axis=0, prepend=0)).max() <= 2 * ACCELERATION_RAD + 1e-6
    assert np.abs(steps[0]).max() <= ACCELERATION_RAD + 1e-6
    np.testing.assert_allclose(targets[-1], TARGET, atol=1e-6)


def test_a_chunk_asked_early_goes_on_with_the_plan_of_the_one_before() -> None:
    reaching = policy()
    first = rows_of(reaching, seen(10, START))
    second = rows_of(reaching, seen(14, START))
    np.testing.assert_array_equal(second[:12], first[4:])


def test_rows_of_several_periods_go_on_with_the_row_that_acts() -> None:
    """Of a skill of half the control rate: four rows are over after eight ticks."""
    reaching = policy()
    first = rows_of(reaching, seen(10, START))
    second = rows_of(reaching, replace(seen(18, START), periods=2))
    np.testing.assert_array_equal(second[:12], first[4:])


def test_a_joint_far_from_its_plan_is_where_the_next_plan_begins() -> None:
    reaching = policy()
    rows_of(reaching, seen(1, START))
    moved = START + 0.5
    rows = rows_of(reaching, seen(9, moved))
    assert np.abs(rows[0, :7] - moved).max() <= ACCELERATION_RAD + 1e-6


def test_after_a_hold_the_next_plan_begins_at_the_joints_not_at_rows_that_never_acted() -> None:
    asked = seen(4, START)

    def ahead(**parts: Executed) -> float:
        reaching = policy()
        rows_of(reaching, seen(1, START))
        rows = rows_of(reaching, replace(asked, executed=parts))
        return float(np.abs(rows[0, :7] - START).max())

    assert ahead() > 4 * ACCELERATION_RAD
    assert ahead(arm=Executed("", 1)) > 4 * ACCELERATION_RAD
    assert ahead(arm=Executed("refused", None)) <= ACCELERATION_RAD + 1e-6
    assert ahead(arm=Executed("no_row", None)) <= ACCELERATION_RAD + 1e-6


def test_a_reset_forgets_the_plan() -> None:
    reaching = policy()
    rows_of(reaching, seen(1, START))
    reaching.reset()
    rows = rows_of(reaching, seen(9, START))
    assert np.abs(rows[0, :7] - START).max() <= ACCELERATION_RAD + 1e-6


@pytest.mark.parametrize(("opening_m", "output"), [(0.0, -1.0), (0.02, -0.5), (0.08, 1.0)])
def test_the_opening_is_normalised(opening_m: float, output: float) -> None:
    reaching = JointReachPolicy.from_options(SKILL, {**OPTIONS, "opening_m": opening_m})
    assert rows_of(reaching, seen(1, START))[0, 7] == output


def test_a_state_of_another_size_is_refused() -> None:
    with pytest.raises(PolicyError) as caught:
        policy().infer(Observation(1, np.zeros(8), ""))
    assert str(caught.value) == "joint_reach: expected a state of shape (9,), got (8,)"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "1 problem(s):\n  target_rad: is missing"),
        ({**OPTIONS, "target_rad": [0.0] * 6},
         "expected target_rad of 7 joints, panda_joint1, panda_joint2, panda_joint3, panda_joint4, "
         "panda_joint5, panda_joint6, panda_joint7, got 6"),
        ({**OPTIONS, "opening_rad": 0.1},
         "expected opening_m or opening_rad, and a slot of gripper_position behind the arm's; or "
         "none, got [0.02, 0.1] and slots ['gripper_position']"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        JointReachPolicy.from_options(SKILL, options)
    assert str(caught.value) == f"joint_reach policy: {text}"


def test_joints_alone_are_there_when_each_is_near_its_target() -> None:
    reaching = JointReachPolicy.from_options(SIX, SIX.policy.options)
    target = np.array(SIX.policy.options["target_rad"], dtype=float)
    rows = reaching.infer(Observation(1, target - [0.031, 0, 0, 0, 0, 0], ""))
    assert isinstance(rows, np.ndarray) and rows.shape == (16, 6)
    assert np.abs(rows[0] - target).max() <= 0.031
    there = reaching.infer(Observation(2, target - 0.029, ""))
    assert there == Done("every joint is within 0.03 rad of the target")


def test_a_skill_that_does_not_command_joint_positions_is_refused() -> None:
    with pytest.raises(ConfigError) as caught:
        JointReachPolicy.from_options(TWELVE_WIDE, OPTIONS)
    assert str(caught.value) == (
        "joint_reach policy: expected a first slot of joint_position, got slot [0, 5] "
        "cartesian_delta"
    )


def test_an_arm_of_six_joints_and_a_turning_gripper_are_reached_without_a_layout() -> None:
    names = [f"j{number}" for number in range(6)]
    skill = type(SKILL).model_validate(
        SKILL.model_dump()
        | {
            "state_contract": {
                "dim": 7,
                "joints": [{"names": [*names, "jaw"], "quantity": "position", "unit": "rad"}],
            },
            "action_contract": {
                "dim": 7,
                "slots": [
                    {"range": [0, 5], "control_mode": "joint_position", "joint_names": names},
                    {"range": [6, 6], "control_mode": "gripper_position", "ee": "hand",
                     "scale": 0.4, "offset": 0.4},
                ],
            },
        }
    )  # fmt: skip
    target = [0.1, -0.1, 0.2, -0.2, 0.3, -0.3]
    options: dict[str, Any] = {"target_rad": target, "opening_rad": 0.6}
    reaching = JointReachPolicy.from_options(skill, options)
    rows = rows_of(reaching, Observation(1, np.append(np.array(target) + 0.031, 0.0), ""))
    np.testing.assert_allclose(rows[-1], [*target, 0.5], atol=1e-6)
