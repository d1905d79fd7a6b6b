"""A skill's own limits against its robot's, mode by mode: they may tighten, never loosen."""

from __future__ import annotations

import pytest

from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.limit_overrides import limit_problems
from fairlead.skill.manifest import SkillLimit, load_skill

DUAL, MOBILE = "dual_panda", "panda_mobile"
ROBOTS = {DUAL: load_robot(DUAL), MOBILE: load_robot(MOBILE)}
SKILLS = {DUAL: load_skill("dual-panda-lift"), MOBILE: load_skill("oracle-counter-to-cabinet")}
MODES = (
    "arm: cartesian_delta; gripper: gripper_position; base: joint_velocity, body_twist; "
    "composite: composite_mode"
)


def problems(robot: str, *limits: SkillLimit) -> list[str]:
    return limit_problems(SKILLS[robot].model_copy(update={"limits": limits}), ROBOTS[robot], "sim")


@pytest.mark.parametrize(
    ("robot", "part", "mode", "name", "value"),
    [
        (DUAL, "right_arm", "joint_velocity", "velocity_limit", 2.0),
        (DUAL, "left_arm", "cartesian_pose", "lower_y", -0.2),
        (DUAL, "left_arm", "cartesian_pose", "upper_z", 1.6),
        (DUAL, "left_arm", "cartesian_pose", "angular_step_limit", 0.1),
        (DUAL, "left_arm", "cartesian_twist", "angular_limit", 2.5),
        (DUAL, "right_hand", "dex_hand_joint", "step_limit", 0.14),
        (MOBILE, "arm", "cartesian_delta", "linear_limit", 0.0867),
        (MOBILE, "arm", "cartesian_delta", "angular_step_limit", 0.1),
        (MOBILE, "base", "joint_velocity", "step_limit", 1.5),
        (MOBILE, "base", "joint_velocity", "velocity_limit", 1.0),
        (MOBILE, "gripper", "gripper_position", "lower", 0.01),
        (MOBILE, "gripper", "gripper_position", "upper", 0.08),
    ],
)
def test_a_limit_up_to_the_robots_own_is_admitted(
    robot: str, part: str, mode: str, name: str, value: float
) -> None:
    limit = SkillLimit(part=part, control_mode=mode, name=name, value=value)
    assert problems(robot, limit) == []


@pytest.mark.parametrize(
    ("robot", "part", "mode", "name", "value", "text"),
    [
        (DUAL, "left_arm", "cartesian_pose", "lower_y", -0.21,
         "expected at least -0.2 and below upper, 1, got -0.21"),
        (DUAL, "left_arm", "cartesian_pose", "upper_x", 0.91,
         "expected above lower, 0.15, and at most 0.9, got 0.91"),
        (DUAL, "left_arm", "cartesian_pose", "lower_y", 1.0,
         "expected at least -0.2 and below upper, 1, got 1"),
        (DUAL, "left_arm", "cartesian_twist", "linear_limit", 1.01,
         "expected above 0 and at most 1, got 1.01"),
        (DUAL, "left_gripper", "gripper_binary", "step_limit", 1.0, "no such limit (valid: none)"),
        (MOBILE, "arm", "cartesian_delta", "linear_limit", 0.1,
         "expected above 0 and at most 0.0867, got 0.1"),
        (MOBILE, "arm", "cartesian_delta", "linear_limit", 0.0,
         "expected above 0 and at most 0.0867, got 0"),
        (MOBILE, "base", "joint_velocity", "step_limit", 2.5,
         "expected above 0 and at most 1.5, got 2.5"),
        (MOBILE, "base", "joint_velocity", "velocity_limit", 1.1,
         "expected above 0 and at most 1, got 1.1"),
        (MOBILE, "gripper", "gripper_position", "lower", -0.01,
         "expected at least 0 and below upper, 0.08, got -0.01"),
        (MOBILE, "gripper", "gripper_position", "upper", 0.09,
         "expected above lower, 0, and at most 0.08, got 0.09"),
        (MOBILE, "gripper", "gripper_position", "speed", 1.0,
         "no such limit (valid: lower, upper, step_limit)"),
        (MOBILE, "arm", "joint_velocity", "step_limit", 1.0,
         f"no such part and mode (valid: {MODES})"),
    ],
)  # fmt: skip
def test_a_limit_beyond_the_robots_own_is_refused(
    robot: str, part: str, mode: str, name: str, value: float, text: str
) -> None:
    limit = SkillLimit(part=part, control_mode=mode, name=name, value=value)
    assert problems(robot, limit) == [f"limits: {part} {mode} {name}: {text} (profile sim)"]


def test_ends_of_a_range_may_not_cross_each_other_either() -> None:
    ends = {"lower_y": 0.3, "upper_y": 0.3}
    limits = tuple(
        SkillLimit(part="left_arm", control_mode="cartesian_pose", name=name, value=value)
        for name, value in ends.items()
    )
    assert problems(DUAL, *limits) == [
        "limits: left_arm cartesian_pose upper_y: expected above lower, 0.3, and at most 1, got 0.3"
        " (profile sim)"
    ]


def test_limits_are_of_parts_that_the_skill_claims() -> None:
    limit = SkillLimit(part="arm", control_mode="cartesian_delta", name="linear_limit", value=0.001)
    driving = load_skill("go-to").model_copy(update={"limits": (limit,)})
    found = Admission(driving, ROBOTS[MOBILE]).problems()
    assert found == ["limits: expected a part that the skill commands, got 'arm' (valid: base)"]
