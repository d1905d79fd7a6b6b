"""What a layout needs from its bindings, and how a manifest that lacks it is refused."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.state_contract import StateContract
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS

# The founding record's own fixture: it must load.
RECORD = {
    "eef_frame": "panda_hand_tcp",
    "base_frame": "base_link",
    "world_frame": "odom",
    "gripper_qpos_joints": ["panda_gripper"],
    "quaternion_convention": "xyzw",
}
PICK = RECORD | {"object_frame": "object", "goal_frame": "goal"}


def refusal(data: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as caught:
        StateContract.model_validate(data)
    return "\n".join(
        f"{'.'.join(map(str, e['loc']))}: {e['msg']}" if e["loc"] else e["msg"]
        for e in caught.value.errors()
    )


def test_all_layouts_but_gr1_have_a_width() -> None:
    assert set(LAYOUTS) - set(LAYOUT_DIMS) == {"gr1"}


def test_the_records_fixture_loads() -> None:
    contract = StateContract.model_validate(
        {"layout": "human300_16d", "dim": 16, "bindings": RECORD}
    )
    assert contract.bindings.eef_frame == "panda_hand_tcp"
    assert contract.bindings.eef_rotation_frame is None
    assert contract.bindings.gripper_qpos_joints == ("panda_gripper",)


def test_defaults_are_the_records() -> None:
    bindings = StateContractBindings()
    assert bindings.world_frame == "map"
    assert bindings.quaternion_convention == "xyzw"
    assert bindings.gripper_qpos_joints == ()


def test_a_layout_without_bindings_is_refused_with_the_whole_list() -> None:
    assert refusal({"layout": "human300_16d", "dim": 16}) == (
        "Value error, bindings: layout human300_16d also needs "
        "eef_frame, base_frame, gripper_qpos_joints"
    )
    assert refusal({"layout": "mobile_pick_30d", "dim": 30, "bindings": {"world_frame": None}}) == (
        "Value error, bindings: layout mobile_pick_30d also needs "
        "eef_frame, base_frame, world_frame, gripper_qpos_joints, object_frame, goal_frame"
    )


@pytest.mark.parametrize("field", LAYOUTS["mobile_pick_30d"].required)
def test_each_required_field_alone_is_missed(field: str) -> None:
    bindings: dict[str, object] = {n: value for n, value in PICK.items() if n != field}
    if field == "world_frame":
        bindings[field] = None  # absent means "map"
    assert refusal({"layout": "mobile_pick_30d", "dim": 30, "bindings": bindings}) == (
        f"Value error, bindings: layout mobile_pick_30d also needs {field}"
    )
    assert LAYOUTS["mobile_pick_30d"].missing(StateContractBindings(**PICK)) == []  # type: ignore[arg-type]


def test_wrong_dim_and_missing_fields_are_reported_together() -> None:
    assert refusal(
        {"layout": "human300_16d", "dim": 30, "bindings": RECORD | {"eef_frame": None}}
    ) == (
        "Value error, dim: expected 16 for layout human300_16d, got 30\n"
        "bindings: layout human300_16d also needs eef_frame"
    )


def test_an_unknown_layout_is_refused_with_the_valid_ones() -> None:
    assert refusal({"layout": "smolvla_9d", "dim": 9, "bindings": RECORD}) == (
        "layout: Value error, expected a layout, got 'smolvla_9d' (valid: aloha, base_pose_6d, "
        "gr1, human300_16d, libero, libero_eef8d, mobile_pick_30d, panda_omron_53d, rc365 "
        "from fairlead 0.1.0)"
    )


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            {"gripper_qpos_joints": ["a", "b", "c"]},
            "bindings: Value error, gripper_qpos_joints: expected two different joints, "
            "or one to be mirrored, got ['a', 'b', 'c']",
        ),
        (
            {"gripper_qpos_joints": ["a", "a"]},
            "bindings: Value error, gripper_qpos_joints: expected two different joints, "
            "or one to be mirrored, got ['a', 'a']",
        ),
        (
            {"quaternion_convention": "xyz"},
            "bindings.quaternion_convention: Input should be 'xyzw' or 'wxyz'",
        ),
        ({"eef_fame": "x"}, "bindings.eef_fame: Extra inputs are not permitted"),
        ({"eef_frame": ""}, "bindings.eef_frame: String should have at least 1 character"),
    ],
)
def test_a_binding_that_does_not_fit_is_named(change: dict[str, Any], text: str) -> None:
    assert refusal({"layout": "human300_16d", "dim": 16, "bindings": RECORD | change}) == text


def test_two_gripper_joints_and_wxyz_are_accepted() -> None:
    bindings = StateContractBindings.model_validate(
        RECORD | {"gripper_qpos_joints": ["l", "r"], "quaternion_convention": "wxyz"}
    )
    assert bindings.gripper_qpos_joints == ("l", "r")


@pytest.mark.parametrize(
    ("layout", "dim", "bindings", "text"),
    [
        ("libero_eef8d", 8, RECORD, "base_frame: layout libero_eef8d reads none (valid: eef_frame, "
         "world_frame, gripper_qpos_joints, eef_rotation_frame, quaternion_signs)"),
        ("human300_16d", 16, PICK | {"goal_frame": None},
         "object_frame: layout human300_16d reads none (valid: eef_frame, base_frame, world_frame, "
         "gripper_qpos_joints, eef_rotation_frame, quaternion_convention, quaternion_signs)"),
        ("aloha", 14, {"eef_frame": "hand", "quaternion_convention": "wxyz"},
         "eef_frame: layout aloha reads none (valid: joint_names)\n"
         "quaternion_convention: layout aloha reads none (valid: joint_names)"),
        ("libero", 9, {"world_frame": "odom"},
         "world_frame: layout libero reads none (valid: joint_names, gripper_qpos_joints)"),
        ("base_pose_6d", 6, {"base_frame": "b", "quaternion_signs": {"base_frame": "+w"}},
         "quaternion_signs: layout base_pose_6d reads none (valid: base_frame, world_frame)"),
    ],
)  # fmt: skip
def test_a_binding_that_the_layout_does_not_read_is_refused_with_those_it_does(
    layout: str, dim: int, bindings: dict[str, Any], text: str
) -> None:
    wanted = f"Value error, {text}"
    assert refusal({"layout": layout, "dim": dim, "bindings": bindings}) == wanted


def test_what_a_binding_would_be_anyway_is_no_binding() -> None:
    """A manifest that was loaded and written again has all of them."""
    contract = StateContract(layout="libero", dim=9)
    assert StateContract.model_validate(contract.model_dump(mode="json")) == contract
