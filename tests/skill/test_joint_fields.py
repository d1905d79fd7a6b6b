"""State vectors of joints alone: any width, order and units declared, the rest refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.slots import Slot
from fairlead.skill.state_contract import JointField, StateContract

ARM = [f"panda_joint{number}" for number in range(1, 8)]
TURNS = {"names": ARM, "quantity": "position", "unit": "rad"}
REACH = load_skill("panda-joint-reach")


def refusal(**fields: Any) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        checked_model("state_contract", StateContract, fields)
    return [line.strip() for line in str(caught.value).splitlines()[1:]]


def problems(robot: str, *fields: dict[str, Any]) -> list[str]:
    """What is said against a skill with this state, beside what is said against its actions."""
    width = sum(len(field["names"]) for field in fields)
    contract = StateContract.model_validate({"dim": width, "joints": fields})
    skill: SkillManifest = REACH.model_copy(update={"state_contract": contract})
    return [p for p in admission_problems(skill, load_robot(robot)) if "state_contract" in p]


@pytest.mark.parametrize("width", [5, 6, 7])
def test_any_number_of_joints_is_admitted(width: int) -> None:
    assert problems("panda", TURNS | {"names": ARM[:width]}) == []


def test_every_joint_of_a_mobile_arm_is_admitted_with_its_own_unit() -> None:
    assert problems(
        "panda_mobile",
        {"names": ["base_x", "base_y"], "quantity": "position", "unit": "m"},
        {"names": ["base_yaw", *ARM], "quantity": "position", "unit": "deg"},
        {"names": ["panda_gripper"], "quantity": "position", "unit": "m"},
        {"names": ["base_yaw"], "quantity": "velocity", "unit": "deg/s"},
    ) == []  # fmt: skip


def test_joint_the_robot_does_not_measure_is_refused_with_those_it_does() -> None:
    assert problems("panda", TURNS | {"names": [*ARM[:6], "elbow"]}) == [
        "state_contract.joints.0: robot panda measures no joint 'elbow' (valid: "
        + ", ".join([*ARM, "panda_gripper", "panda_finger_joint1", "panda_finger_joint2"])
        + ")"
    ]


def test_unit_that_does_not_fit_the_joint_is_refused_with_those_that_do() -> None:
    assert problems(
        "panda",
        TURNS | {"names": ["panda_gripper"]},
        {"names": ["panda_joint1"], "quantity": "velocity", "unit": "m/s"},
    ) == [
        "state_contract.joints.0: unit rad does not fit joint panda_gripper, which is prismatic "
        "(valid: m)",
        "state_contract.joints.1: unit m/s does not fit joint panda_joint1, which is revolute "
        "(valid: rad/s, deg/s)",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("fields", "lines"),
    [
        (
            {"dim": 9, "joints": [TURNS]},
            ["dim: expected 7, one per joint in joints, got 9"],
        ),
        (
            {"dim": 8, "joints": [TURNS, TURNS | {"names": ARM[:1], "unit": "deg"}]},
            ["joints: the position of 'panda_joint1' is given 2 times"],
        ),
        (
            {"dim": 7, "layout": "libero", "joints": [TURNS]},
            ["layout: not allowed beside joints"],
        ),
        (
            {"dim": 7, "bindings": {"eef_frame": "hand"}, "joints": [TURNS]},
            ["bindings: not allowed beside joints"],
        ),
        (
            {"dim": 7},
            [
                "expected layout or joints, got neither (layouts valid: aloha, "
                "base_pose_6d, gr1, human300_16d, libero, libero_eef8d, mobile_pick_30d, "
                "panda_omron_53d, rc365 "
                "from fairlead 0.1.0)"
            ],
        ),
        (
            {"dim": 7, "layout": "libro"},
            [
                "layout: expected a layout, got 'libro' (valid: aloha, base_pose_6d, gr1, "
                "human300_16d, libero, libero_eef8d, mobile_pick_30d, panda_omron_53d, rc365 "
                "from fairlead 0.1.0)"
            ],
        ),
        (
            {"dim": 7, "joints": [{"names": ARM, "quantity": "position"}]},
            ["joints.0.unit: is missing"],
        ),
        (
            {"dim": 7, "joints": [TURNS | {"unit": "deg/s"}]},
            ["joints.0: unit: expected one of a position, got 'deg/s' (valid: rad, deg, m)"],
        ),
        (
            {"dim": 7, "joints": [TURNS | {"sign": -1}]},
            ["joints.0.sign: unknown key (valid: names, quantity, unit, scale, offset)"],
        ),
        (
            {"dim": 7, "joints": [TURNS | {"scale": 0.0, "offset": [1.0, 2.0]}]},
            [
                "joints.0: scale: expected numbers that are finite and not 0, got [0.0]",
                "joints.0: offset: expected 1 or 7 number(s), got 2",
            ],
        ),
    ],
)  # fmt: skip
def test_contract_that_does_not_fit_says_what_was_expected(
    fields: dict[str, Any], lines: list[str]
) -> None:
    assert refusal(**fields) == lines


def test_contract_survives_its_own_dump() -> None:
    contract = StateContract.model_validate({"dim": 7, "joints": [TURNS]})
    assert StateContract.model_validate(contract.model_dump(mode="json")) == contract


def test_contract_without_a_scale_has_the_hash_it_had_before_there_were_scales() -> None:
    """Datasets and claims know a skill by it."""
    assert "scale" not in str(REACH.state_contract.model_dump(mode="json"))


def test_a_scaled_number_becomes_by_a_slot_what_the_joint_measured() -> None:
    given = {"unit": "deg", "scale": [0.9, -1.8, 0.5], "offset": [3.0, 0.0, -7.0]}
    seen = JointField.model_validate({"names": ARM[:3], "quantity": "position", **given})
    moved = Slot.model_validate(
        {"range": [0, 2], "control_mode": "joint_position", "joint_names": ARM[:3], **given}
    )
    numbers = seen.numbers([0.5, -1.0, 0.0])
    assert numbers == pytest.approx(
        [(math.degrees(0.5) - 3.0) / 0.9, math.degrees(1.0) / 1.8, 14.0], rel=1e-12
    )
    back = zip(numbers, moved.scales(), moved.offsets(), strict=True)
    assert [scale * number + offset for number, scale, offset in back] == pytest.approx(
        [0.5, -1.0, 0.0], abs=1e-12
    )
