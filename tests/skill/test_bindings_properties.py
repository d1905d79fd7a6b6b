"""What holds for every set of bindings and every layout."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fairlead.skill.bindings import PoseBinding, QuaternionSign, StateContractBindings
from fairlead.skill.state_contract import StateContract
from tests.assembler.every_layout import LAYOUTS

FRAME_FIELDS = (
    *("eef_frame", "eef_rotation_frame", "base_frame", "world_frame"),
    *("object_frame", "goal_frame"),
)
names = st.text(min_size=1, max_size=8)
layouts = st.sampled_from(sorted(LAYOUTS))
different = st.lists(names, max_size=2, unique=True)

frames = st.fixed_dictionaries({}, optional=dict.fromkeys(FRAME_FIELDS, st.none() | names))
free = st.fixed_dictionaries(
    {},
    optional={
        "gripper_qpos_joints": different,
        "joint_names": st.lists(names, max_size=16, unique=True),
        "quaternion_convention": st.sampled_from(["xyzw", "wxyz"]),
        "quaternion_signs": st.dictionaries(
            st.sampled_from(get_args(PoseBinding)), st.sampled_from(get_args(QuaternionSign))
        ),
    },
)
bindings = st.builds(lambda a, b: a | b, frames, free)


DEFAULTS = {"world_frame": "map", "quaternion_convention": "xyzw"}
_ROBOT = ("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints")
_ROTATIONS = ("eef_rotation_frame", "quaternion_convention", "quaternion_signs")
READ = {
    "aloha": ("joint_names",),
    "base_pose_6d": ("base_frame", "world_frame"),
    "gr1": (*_ROBOT, *_ROTATIONS),
    "human300_16d": (*_ROBOT, *_ROTATIONS),
    "libero": ("joint_names", "gripper_qpos_joints"),
    "libero_eef8d": (_ROBOT[0], *_ROBOT[2:], _ROTATIONS[0], _ROTATIONS[2]),
    "mobile_pick_30d": (*_ROBOT, "object_frame", "goal_frame", *_ROTATIONS),
    "panda_omron_53d": (*_ROBOT, *_ROTATIONS, "joint_names"),
    "rc365": (*_ROBOT, *_ROTATIONS),
}


def refusal(layout: str, dim: int, data: dict[str, Any]) -> str:
    """The one error of a contract, "" if it loads."""
    try:
        StateContract.model_validate({"layout": layout, "dim": dim, "bindings": data})
    except ValidationError as error:
        assert error.error_count() == 1
        return error.errors()[0]["msg"].removeprefix("Value error, ")
    return ""


def expected_refusal(layout: str, dim: int, data: dict[str, Any]) -> str:
    """The same rules written a second time, from the raw manifest."""
    shape, problems = LAYOUTS[layout], []
    if shape.dim not in (None, dim):
        problems.append(f"dim: expected {shape.dim} for layout {layout}, got {dim}")
    missing = [n for n in shape.required if not ({"world_frame": "map"} | data).get(n)]
    if missing:
        problems.append(f"bindings: layout {layout} also needs {', '.join(missing)}")
    given_joints = len(data.get("joint_names", ()))
    wanted = {"libero": 7, "aloha": 14, "panda_omron_53d": 7}.get(layout, 0)
    if given_joints and given_joints != wanted:
        other = "; joints in any number: state_contract.joints" if wanted else ""
        problems.append(
            f"joint_names: expected {wanted} for layout {layout}, got {given_joints}{other}"
        )
    reads = READ[layout]
    problems += [
        f"{name}: layout {layout} reads none (valid: {', '.join(reads)})"
        for name in [
            *FRAME_FIELDS[:4],
            "gripper_qpos_joints",
            "quaternion_convention",
            "quaternion_signs",
            *FRAME_FIELDS[4:],
        ]
        if data.get(name) and data[name] != DEFAULTS.get(name) and name not in reads
    ]
    problems += [
        f"quaternion_signs: layout {layout} has no rotation of {name}"
        for name in data.get("quaternion_signs", {})
        if "quaternion_signs" in reads and name not in reads
    ]
    return "\n".join(problems)


@given(layouts, st.integers(1, 40), bindings)
def test_every_problem_is_in_one_error_and_nothing_else_is_refused(
    layout: str, dim: int, data: dict[str, Any]
) -> None:
    assert refusal(layout, dim, data) == expected_refusal(layout, dim, data)


@given(bindings)
def test_bindings_survive_a_round_trip(data: dict[str, Any]) -> None:
    loaded = StateContractBindings.model_validate(data)
    assert StateContractBindings.model_validate_json(loaded.model_dump_json()) == loaded
    assert StateContractBindings.model_validate(loaded.model_dump(mode="json")) == loaded


@given(layouts, bindings)
def test_missing_fields_are_a_subset_of_the_table_in_its_order(
    layout: str, data: dict[str, Any]
) -> None:
    loaded = StateContractBindings.model_validate(data)
    missing = LAYOUTS[layout].missing(loaded)
    assert [name for name in LAYOUTS[layout].required if name in missing] == missing
    assert all(not getattr(loaded, name) for name in missing)


@given(names.filter(lambda name: name not in StateContractBindings.model_fields))
def test_unknown_field_is_refused_by_its_name(name: str) -> None:
    with pytest.raises(ValidationError) as error:
        StateContractBindings.model_validate({name: "x"})
    assert error.value.errors()[0]["loc"] == (name,)
    assert error.value.errors()[0]["msg"] == "Extra inputs are not permitted"


@given(st.lists(names, max_size=5))
def test_gripper_is_none_one_or_two_different_joints(joints: list[str]) -> None:
    good = len(joints) <= 2 and len(set(joints)) == len(joints)
    if good:
        loaded = StateContractBindings.model_validate({"gripper_qpos_joints": joints})
        assert list(LAYOUTS["human300_16d"].bound_gripper(loaded)) == joints
        return
    with pytest.raises(ValidationError, match="expected two different joints"):
        StateContractBindings.model_validate({"gripper_qpos_joints": joints})


def test_joint_names_that_repeat_are_refused() -> None:
    with pytest.raises(ValidationError) as error:
        StateContractBindings(joint_names=("a", "b", "a"))
    assert error.value.errors()[0]["msg"] == (
        "Value error, joint_names: expected different joints, got ['a', 'b', 'a']"
    )


@pytest.mark.parametrize("sign", ["w", "+v", "", "++"])
def test_sign_that_is_none_is_refused_with_the_valid_ones(sign: str) -> None:
    with pytest.raises(ValidationError) as error:
        StateContractBindings.model_validate({"quaternion_signs": {"eef_frame": sign}})
    assert error.value.errors()[0]["loc"] == ("quaternion_signs", "eef_frame")
    assert error.value.errors()[0]["msg"] == (
        "Input should be '+w', '-w', '+x', '-x', '+y', '-y', '+z' or '-z'"
    )


def test_joint_space_layouts_need_no_bindings_and_take_others() -> None:
    nothing = StateContract(layout="libero", dim=9).bindings
    libero = LAYOUTS["libero"]
    assert libero.bound_joints(nothing) == tuple(f"panda_joint{n}" for n in range(1, 8))
    assert libero.bound_gripper(nothing) == (
        "panda_finger_joint1",
        "panda_finger_joint2",
    )
    other = StateContractBindings(joint_names=tuple("abcdefg"), gripper_qpos_joints=("thumb",))
    assert libero.bound_joints(other) == tuple("abcdefg")
    assert libero.bound_gripper(other) == ("thumb",)
    assert StateContract(layout="aloha", dim=14).bindings == nothing
    assert len(LAYOUTS["aloha"].bound_joints(nothing)) == 14
