"""The base planner: what goal it takes, and where it refuses to go; no process, no clock."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.policy import Done, Executed, Failed, Observation
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.surroundings import BaseSurroundings, zone_breach
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policies.go_to import GoToPolicy, read_pose

SKILL = load_skill("go-to")
ROBOT = load_robot("panda_mobile")
SQUARE = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
PILLAR = [[1.0, -0.2], [1.4, -0.2], [1.4, 0.2], [1.0, 0.2]]
BASE = BaseSurroundings.model_validate(
    {
        "footprint_m": [[-0.5, -0.25], [0.1, -0.25], [0.1, 0.25], [-0.5, 0.25]],
        "command_frame": "odom",
        "yaw_axis_m": [0.0, 0.0],
        "reaction_s": 0.1,
        "tool_drift_m": 0.0,
        "clearance_drift_m": 0.0,
        "zones": [
            {"name": "room", "kind": "keep_in", "corners_m": SQUARE},
            {"name": "pillar", "kind": "keep_out", "corners_m": PILLAR},
        ],
        "source": "test",
    }
)


def changed(**changes: Any) -> SkillManifest:
    return SkillManifest.model_validate(SKILL.model_dump(mode="json") | changes)


def policy(robot: RobotManifest = ROBOT) -> GoToPolicy:
    return GoToPolicy.for_robot(SKILL, SKILL.policy.options, robot, "sim")


def seen(
    prompt: str,
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
    odom: tuple[float, float, float] | None = None,
    tick: int = 1,
) -> Observation:
    return Observation(tick, np.array([*pose, *(odom or pose)]), prompt)


@pytest.mark.parametrize(
    ("x", "y", "yaw", "words"),
    [
        (1.9, -1.0, 0.0, ""),
        (1.9 + 1e-9, -1.0, 0.0, "1e-09 m outside keep_in zone room"),
        (-1.5, 1.0, 0.0, ""),
        (-1.6, 1.0, 0.0, "0.1 m outside keep_in zone room"),
        (-1.6, 1.0, math.pi, ""),  # turned round, its long end points inwards
        (0.9, 0.0, 0.0, ""),
        (0.9 + 1e-6, 0.0, 0.0, "1e-06 m inside keep_out zone pillar"),
        (1.2, 0.0, 0.0, "0.3 m inside keep_out zone pillar"),
        (1.2, 0.5, 0.0, ""),
    ],
)
def test_the_outline_is_compared_with_every_zone(
    x: float, y: float, yaw: float, words: str
) -> None:
    assert zone_breach(BASE, x, y, yaw) == words


@pytest.mark.parametrize(
    "prompt", ["", "x y yaw", "1 2", "1 2 3 4", "1,2,3", "1 2 nan", "1 2 inf", "1e3 0 0", "0x1 0 0"]
)
def test_a_goal_is_three_plain_numbers_and_nothing_else(prompt: str) -> None:
    assert read_pose(prompt) is None
    said = policy().infer(seen(prompt))
    assert isinstance(said, Failed)
    assert said.kind == "bad_goal"


def test_three_numbers_are_x_y_and_yaw() -> None:
    assert read_pose(" 1.5 -0.25   +3 ") == (1.5, -0.25, 3.0)


def test_the_zones_are_those_of_odom_wherever_the_map_is() -> None:
    """The robot stands at 100, 50 in the map, turned by a quarter: the goal is 2 m ahead."""
    pose, odom = (100.0, 50.0, math.pi / 2), (0.0, 0.0, 0.0)
    assert isinstance(policy().infer(seen("100 52 1.5", pose, odom)), np.ndarray)
    said = policy().infer(seen("100 54 1.5707963", pose, odom))
    assert isinstance(said, Failed)
    assert said.kind == "goal_outside_zones"
    where = "0.15 m outside keep_in zone kitchen"
    assert said.reason == f"at 100 54 1.5707963 the base would be {where}"


def test_it_is_done_at_once_where_it_stands_already() -> None:
    assert isinstance(policy().infer(seen("0.01 0 0.01")), Done)


def test_a_base_that_does_as_told_gets_there_within_scale_and_acceleration() -> None:
    asked, pose, tick = policy(), (0.0, 0.0, 0.0), 1
    before = np.zeros(2)
    for _ in range(400):
        said = asked.infer(seen("-1 0.6 -2", pose, tick=tick))
        if isinstance(said, Done):
            break
        assert isinstance(said, np.ndarray)
        assert said.shape == (SKILL.horizon, 2)
        assert np.abs(said).max() <= 1.0
        for ahead, left in said[: SKILL.execute_steps] * np.array([0.3, 0.6]):
            step = np.abs(np.array([ahead, left]) - before)
            assert (step <= np.array([0.5, 1.0]) * 0.05 + 1e-6).all()
            assert min(abs(ahead), abs(left)) < 0.15  # turns and drives, but for steering
            before = np.array([ahead, left])
            x, y, yaw = pose
            pose = (
                x + ahead * math.cos(yaw) * 0.05,
                y + ahead * math.sin(yaw) * 0.05,
                yaw + left * 0.05,
            )
            tick += 1
    assert isinstance(said, Done)
    assert math.hypot(pose[0] + 1, pose[1] - 0.6) <= 0.03
    assert abs(math.remainder(pose[2] + 2, math.tau)) <= 0.03


def test_rows_of_several_periods_go_on_with_the_rates_of_the_row_that_acts() -> None:
    driving = policy()
    first = driving.infer(seen("1.5 0 0", tick=10))
    assert isinstance(first, np.ndarray)
    second = driving.infer(replace(seen("1.5 0 0", tick=18), periods=2))
    assert isinstance(second, np.ndarray)
    np.testing.assert_array_equal(second[0], first[4])  # from row 3 on


def test_after_a_hold_it_begins_from_standstill() -> None:
    """Else answers that are refused, tick after tick, grow to full speed for a base that stands."""
    planner, held = policy(), {"base": Executed("no_row", None)}
    planner.reset()
    first = []
    for tick in range(1, 13):
        rows = planner.infer(replace(seen("1.0 0.0 0.0", tick=tick), executed=held))
        assert isinstance(rows, np.ndarray)
        first.append(rows[0, 0])
    np.testing.assert_array_equal(first, first[0])


def test_a_skill_that_is_not_driven_like_this_is_refused_by_name() -> None:
    other = load_skill("oracle-counter-to-cabinet")
    with pytest.raises(ConfigError, match="go_to policy: expected layout base_pose_6d"):
        GoToPolicy.for_robot(other, {}, ROBOT, "sim")
    with pytest.raises(ConfigError, match="speed: unknown key"):
        GoToPolicy.for_robot(SKILL, {"speed": 1}, ROBOT, "sim")
    with pytest.raises(ConfigError, match="robot panda has no mobile base with zones"):
        policy(load_robot("panda"))


def test_what_bounds_the_shipped_skill_is_what_its_slot_declares() -> None:
    [slot] = SKILL.action_contract.routed
    assert (slot.axes, slot.scales()) == ((0, 5), (0.3, 0.6))
    with pytest.raises(ConfigError, match="one slot, body_twist of axes"):
        contract = SKILL.action_contract.model_dump(mode="json")
        contract["slots"][0]["axes"] = [0, 1]
        GoToPolicy.for_robot(changed(action_contract=contract), {}, ROBOT, "sim")
