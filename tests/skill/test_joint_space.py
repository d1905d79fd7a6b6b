"""Skills that name joints instead of slots: permuted, converted, or refused; never guessed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from fairlead.errors import ConfigError
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.output_range import declared_range_problems
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.candidate import dispatch

MOBILE = load_robot("panda_mobile")
# The same robot with arm and gripper that take joint positions.
ROBOT = MOBILE.model_copy(
    update={
        "parts": tuple(
            part.model_copy(update={"modes": ("joint_position",)})
            if part.name in ("arm", "gripper")
            else part
            for part in MOBILE.parts
        )
    }
)
ARM = tuple(f"panda_joint{number}" for number in range(1, 8))
SHUFFLED = ("panda_joint7", "panda_gripper", *ARM[:6])


def contract(**fields: Any) -> ActionContract:
    return ActionContract.model_validate(fields)


def refusal(**fields: Any) -> str:
    with pytest.raises(ValidationError) as caught:
        contract(**fields)
    return str(caught.value.errors()[0]["msg"])


def test_names_in_the_policys_order_land_in_the_robots_order() -> None:
    routes = resolve_routes(contract(dim=8, joint_names=SHUFFLED), ROBOT)
    rows = np.arange(1, 17, dtype=np.float32).reshape(2, 8)
    arm, gripper = dispatch(routes, rows, 8)
    assert [ControlMode(part.mode) for part in (arm, gripper)] == [ControlMode.JOINT_POSITION] * 2
    assert (arm.active, gripper.active) == (tuple(range(3, 10)), (10,))
    np.testing.assert_array_equal(
        floats(arm.values, 11),
        [[0, 0, 0, 3, 4, 5, 6, 7, 8, 1, 0], [0, 0, 0, 11, 12, 13, 14, 15, 16, 9, 0]],
    )
    np.testing.assert_array_equal(floats(gripper.values, 11)[:, 10], [2, 10])


def test_degrees_become_radians() -> None:
    routes = resolve_routes(contract(dim=7, joint_names=ARM, joint_unit="deg"), ROBOT)
    rows = np.array([[180, -90, 45, 0, 1, -1, 360]], dtype=np.float32)
    (arm,) = dispatch(routes, rows, 7)
    np.testing.assert_allclose(
        floats(arm.values, 11)[0, 3:10],
        [math.pi, -math.pi / 2, math.pi / 4, 0, math.pi / 180, -math.pi / 180, 2 * math.pi],
        rtol=1e-15,
    )


def test_radians_keep_the_policys_bits() -> None:
    rows = np.random.default_rng(2).uniform(-3, 3, (50, 7)).astype(np.float32)
    for unit in ({}, {"joint_unit": "rad"}):
        routes = resolve_routes(contract(dim=7, joint_names=ARM, **unit), ROBOT)
        (arm,) = dispatch(routes, rows, 7)
        back = floats(arm.values, 11)[:, 3:10].astype(np.float32)
        assert back.tobytes() == rows.tobytes()


def test_an_angle_unit_for_a_sliding_joint_is_refused() -> None:
    with pytest.raises(ConfigError) as caught:
        resolve_routes(contract(dim=8, joint_names=SHUFFLED, joint_unit="deg"), ROBOT)
    assert str(caught.value) == (
        "slot [1, 1] joint_position: unit: deg does not fit joint panda_gripper, which is "
        "prismatic (a slot of its own, without unit, is in m)"
    )


DEGREES = {"control_mode": "joint_position", "joint_names": ARM, "range": [0, 6], "unit": "deg"}


@pytest.mark.parametrize(
    "fields",
    [{"joint_names": ARM, "joint_unit": "deg"}, {"slots": [DEGREES]}],
    ids=["joint_names", "slot"],
)
def test_positions_in_degrees_are_admitted_and_become_radians(fields: dict[str, Any]) -> None:
    panda = load_robot("panda")
    routes = resolve_routes(contract(dim=7, **fields), panda)
    assert declared_range_problems(routes, panda, 1) == []
    rows = np.array([[90, -45, 0, -120, 1, 30, -1]], dtype=np.float32)
    (arm,) = dispatch(routes, rows, 7)
    np.testing.assert_allclose(
        floats(arm.values, 8)[0, :7], np.radians(rows[0].astype(np.float64)), rtol=1e-15
    )


def test_degrees_beside_a_scale_are_a_share_of_a_range_and_compared_with_it() -> None:
    panda = load_robot("panda")
    speed = DEGREES | {"control_mode": "joint_velocity", "scale": 30.0}
    routes = resolve_routes(contract(dim=7, slots=[speed]), panda)
    assert routes[0].scale == (math.radians(30.0),) * 7
    assert declared_range_problems(routes, panda, 1) == []
    routes = resolve_routes(contract(dim=7, slots=[speed | {"scale": 300.0}]), panda)
    assert (
        "full-scale output is [-5.23599, 5.23599]" in declared_range_problems(routes, panda, 1)[0]
    )


def test_scale_of_one_degree_is_refused_and_told_the_unit() -> None:
    panda = load_robot("panda")
    scaled = {**DEGREES, "scale": 0.0174533}
    del scaled["unit"]
    routes = resolve_routes(contract(dim=7, slots=[scaled]), panda)
    [problem, *_] = declared_range_problems(routes, panda, 1)
    assert problem.endswith("; for degrees write unit: deg and no scale")


def test_more_dimensions_than_the_robot_has_joints_are_refused() -> None:
    names = (*MOBILE.joint_names, "left_elbow")
    with pytest.raises(ConfigError) as caught:
        resolve_routes(contract(dim=12, joint_names=names), ROBOT)
    assert str(caught.value).startswith(
        "action_contract: expected at most the 11 joints of robot panda_mobile, got dim 12; "
    )
    assert "robot panda_mobile has no joint 'left_elbow'" in str(caught.value)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"dim": 2, "joint_names": ["a"]},
         "joint_names: expected 2, one per dimension, got 1"),
        ({"dim": 2, "joint_names": ["a", "a"]}, "joint_names: 'a' is given 2 times"),
        ({"dim": 1, "joint_names": ["a"], "slots": [{"range": [0, 0], "discard": True}]},
         "joint_names: not allowed beside slots"),
        ({"dim": 1, "joint_unit": "deg", "slots": [{"range": [0, 0], "discard": True}]},
         "joint_unit: only with joint_names; for degrees in a slot: unit: deg"),
        ({"dim": 1, "slots": [{"range": [0, 0], "discard": True, "joint_unit": "deg"}]},
         "joint_unit: not in a slot; for degrees write unit: deg"),
        ({"dim": 1}, "slots: expected every index of 0..0 to be covered, got no slots"),
    ],
)  # fmt: skip
def test_a_contract_that_contradicts_itself_is_refused(fields: dict[str, Any], text: str) -> None:
    assert refusal(**fields) == f"Value error, {text}"


def test_a_layout_that_nothing_assembles_is_refused_and_the_raw_joints_never_take_its_place() -> (
    None
):
    data = load_skill("pi05-robocasa365-human300-nf4").model_dump(mode="json")
    data["state_contract"]["layout"] = "gr1"
    joint_space = {"dim": 7, "joint_names": list(ARM)}
    for actions in (data["action_contract"], joint_space):
        skill = SkillManifest.model_validate(data | {"action_contract": actions})
        problems = admission_problems(skill, MOBILE)
        said = "layout gr1: no assembler; those that have one: fairlead layout ls"
        assert said in problems
