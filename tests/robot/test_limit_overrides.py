"""A skill's own limits against a two-armed robot's, mode by mode."""

from __future__ import annotations

import pytest

from fairlead.robot.manifest import load_robot
from fairlead.skill.limit_overrides import limit_problems
from fairlead.skill.manifest import SkillLimit, load_skill

ROBOT = load_robot("dual_panda")
SKILL = load_skill("dual-panda-lift")


def problems(part: str, mode: str, name: str, value: float) -> list[str]:
    limit = SkillLimit(part=part, control_mode=mode, name=name, value=value)
    return limit_problems(SKILL.model_copy(update={"limits": (limit,)}), ROBOT, "sim")


@pytest.mark.parametrize(
    ("part", "mode", "name", "value"),
    [
        ("right_arm", "joint_velocity", "velocity_limit", 2.0),
        ("left_arm", "cartesian_pose", "lower_y", -0.2),
        ("left_arm", "cartesian_pose", "upper_z", 1.6),
        ("left_arm", "cartesian_pose", "angular_step_limit", 0.1),
        ("left_arm", "cartesian_twist", "angular_limit", 2.5),
        ("right_hand", "dex_hand_joint", "step_limit", 0.14),
    ],
)
def test_a_limit_up_to_the_robots_own_is_admitted(
    part: str, mode: str, name: str, value: float
) -> None:
    assert problems(part, mode, name, value) == []


@pytest.mark.parametrize(
    ("part", "mode", "name", "value", "text"),
    [
        ("left_arm", "cartesian_pose", "lower_y", -0.21,
         "lower_y: expected at least -0.2 and below upper, 1, got -0.21"),
        ("left_arm", "cartesian_pose", "upper_x", 0.91,
         "upper_x: expected above lower, 0.15, and at most 0.9, got 0.91"),
        ("left_arm", "cartesian_pose", "lower_y", 1.0,
         "lower_y: expected at least -0.2 and below upper, 1, got 1"),
        ("left_arm", "cartesian_twist", "linear_limit", 1.01,
         "linear_limit: expected above 0 and at most 1, got 1.01"),
        ("left_gripper", "gripper_binary", "step_limit", 1.0,
         "step_limit: no such limit (valid: none)"),
    ],
)  # fmt: skip
def test_a_limit_beyond_the_robots_own_is_refused(
    part: str, mode: str, name: str, value: float, text: str
) -> None:
    assert problems(part, mode, name, value) == [f"limits: {part} {mode} {text} (profile sim)"]


def test_ends_of_a_range_may_not_cross_each_other_either() -> None:
    ends = {"lower_y": 0.3, "upper_y": 0.3}
    limits = tuple(
        SkillLimit(part="left_arm", control_mode="cartesian_pose", name=name, value=value)
        for name, value in ends.items()
    )
    assert limit_problems(SKILL.model_copy(update={"limits": limits}), ROBOT, "sim") == [
        "limits: left_arm cartesian_pose upper_y: expected above lower, 0.3, and at most 1, got 0.3"
        " (profile sim)"
    ]
