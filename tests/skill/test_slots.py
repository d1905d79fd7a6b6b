"""Slots: inclusive ranges, the field table, exact cover. Every rule on both its sides."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.modes import ControlMode
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.slots import FIELD_RULES, MODE_NAMES, Slot

CARTESIAN = {"range": [0, 5], "control_mode": "cartesian_delta", "ee": "gripper", "frame": "b"}
POSE = CARTESIAN | {"range": [0, 6], "control_mode": "cartesian_pose"}
TWIST = CARTESIAN | {"control_mode": "cartesian_twist"}
JOINT = {"range": [0, 1], "control_mode": "joint_velocity", "joint_names": ["x", "y"]}
GRIPPER = {"range": [0, 0], "control_mode": "gripper_position", "ee": "gripper"}
BODY = {"range": [0, 5], "control_mode": "body_twist"}
COMPOSITE = {"range": [0, 0], "control_mode": "composite_mode"}
DISCARD = {"range": [0, 0], "discard": True}
VALID: list[dict[str, Any]] = [
    CARTESIAN,
    POSE,
    TWIST,
    JOINT,
    JOINT | {"control_mode": "joint_position"},
    JOINT | {"control_mode": "dex_hand_joint"},
    GRIPPER,
    GRIPPER | {"control_mode": "gripper_binary"},
    GRIPPER | {"control_mode": "gripper_binary", "threshold": 0.0},
    BODY,
    COMPOSITE,
    DISCARD,
]
MODES = ", ".join(MODE_NAMES)


def refusal(model: type[Slot] | type[ActionContract], data: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as caught:
        model.model_validate(data)
    return "\n".join(str(error["msg"]) for error in caught.value.errors())


@pytest.mark.parametrize("data", VALID, ids=lambda d: str(d.get("control_mode", "discard")))
def test_a_slot_with_what_its_mode_needs_is_accepted(data: dict[str, Any]) -> None:
    slot = Slot.model_validate(data)
    assert slot.width == data["range"][1] - data["range"][0] + 1
    assert (slot.mode is None) == slot.discard


def test_every_mode_that_can_be_routed_to_has_an_accepting_case() -> None:
    assert {d["control_mode"] for d in VALID if "control_mode" in d} == set(MODE_NAMES)
    assert set(ControlMode) - set(FIELD_RULES) == {
        ControlMode.JOINT_TORQUE,
        ControlMode.JOINT_TRAJECTORY,
        ControlMode.FOOT_PLACEMENT,
    }


@pytest.mark.parametrize(
    ("data", "text"),
    [
        # the range
        (
            DISCARD | {"range": [3, 2]},
            "slot [3, 2] discard: range: expected 0 <= first <= last, got [3, 2]",
        ),
        (
            DISCARD | {"range": [-1, 2]},
            "slot [-1, 2] discard: range: expected 0 <= first <= last, got [-1, 2]",
        ),
        # routed or discarded, nothing in between
        (
            {"range": [0, 0]},
            f"slot [0, 0]: expected control_mode or discard: true, got neither (valid: {MODES})",
        ),
        (
            {"range": [0, 0], "control_mode": "warp"},
            f"slot [0, 0] warp: expected control_mode or discard: true, got 'warp' "
            f"(valid: {MODES})",
        ),
        (
            {"range": [0, 0], "control_mode": "joint_trajectory"},
            "slot [0, 0] joint_trajectory: expected control_mode or discard: true, "
            f"got 'joint_trajectory' (valid: {MODES})",
        ),
        # discard forbids everything else
        (
            {
                "range": [0, 5],
                "discard": True,
                "control_mode": "cartesian_delta",
                "ee": "g",
                "frame": "b",
                "joint_names": ["x"],
                "axes": [0],
                "scale": 1.0,
                "offset": 0.0,
            },
            "slot [0, 5] cartesian_delta: control_mode: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: ee: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: frame: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: joint_names: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: axes: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: scale: not allowed with discard\n"
            "slot [0, 5] cartesian_delta: offset: not allowed with discard",
        ),
        # threshold: modes of two ends only
        (
            BODY | {"threshold": 0.0},
            "slot [0, 5] body_twist: threshold: not allowed with body_twist",
        ),
        (
            DISCARD | {"threshold": 0.0},
            "slot [0, 0] discard: threshold: not allowed with discard",
        ),
        (
            GRIPPER | {"control_mode": "gripper_binary", "threshold": float("nan")},
            "Input should be a finite number",
        ),
        # cartesian_*: ee and frame, nothing else
        (
            {"range": [0, 5], "control_mode": "cartesian_delta"},
            "slot [0, 5] cartesian_delta: ee: required with cartesian_delta\n"
            "slot [0, 5] cartesian_delta: frame: required with cartesian_delta",
        ),
        (
            CARTESIAN | {"joint_names": ["x"], "axes": [0]},
            "slot [0, 5] cartesian_delta: joint_names: not allowed with cartesian_delta\n"
            "slot [0, 5] cartesian_delta: width: expected 1 dimension(s), one per axis, got 6",
        ),
        (
            CARTESIAN | {"range": [0, 4]},
            "slot [0, 4] cartesian_delta: width: expected 6 dimension(s), or axes, got 5",
        ),
        (
            POSE | {"range": [0, 5]},
            "slot [0, 5] cartesian_pose: width: expected 7 dimension(s), got 6",
        ),
        (
            TWIST | {"frame": ""},
            "slot [0, 5] cartesian_twist: frame: required with cartesian_twist",
        ),
        # joint_*: as many names as dimensions
        (
            {"range": [0, 1], "control_mode": "joint_position"},
            "slot [0, 1] joint_position: joint_names: required with joint_position",
        ),
        (
            JOINT | {"range": [0, 2]},
            "slot [0, 2] joint_velocity: width: expected 2 dimension(s), one per joint name, got 3",
        ),
        (
            JOINT | {"joint_names": ["x", "x"]},
            "slot [0, 1] joint_velocity: joint_names: x is given twice",
        ),
        (
            JOINT | {"ee": "g", "frame": "b"},
            "slot [0, 1] joint_velocity: ee: not allowed with joint_velocity\n"
            "slot [0, 1] joint_velocity: frame: not allowed with joint_velocity",
        ),
        # gripper_*: ee, one dimension
        (
            {"range": [0, 0], "control_mode": "gripper_binary"},
            "slot [0, 0] gripper_binary: ee: required with gripper_binary",
        ),
        (
            GRIPPER | {"range": [0, 1]},
            "slot [0, 1] gripper_position: width: expected 1 dimension(s), got 2",
        ),
        (
            GRIPPER | {"frame": "b"},
            "slot [0, 0] gripper_position: frame: not allowed with gripper_position",
        ),
        # body_twist: six dimensions or axes
        (
            BODY | {"range": [0, 2]},
            "slot [0, 2] body_twist: width: expected 6 dimension(s), or axes, got 3",
        ),
        (
            BODY | {"range": [0, 1], "axes": [0, 1, 5]},
            "slot [0, 1] body_twist: width: expected 3 dimension(s), one per axis, got 2",
        ),
        (
            BODY | {"range": [0, 1], "axes": [5, 0]},
            "slot [0, 1] body_twist: axes: expected ascending indices out of 0..5, got [5, 0]",
        ),
        (
            BODY | {"range": [0, 1], "axes": [0, 6]},
            "slot [0, 1] body_twist: axes: expected ascending indices out of 0..5, got [0, 6]",
        ),
        (
            BODY | {"range": [0, 0], "axes": []},
            "slot [0, 0] body_twist: axes: expected ascending indices out of 0..5, got []",
        ),
        (BODY | {"frame": "b"}, "slot [0, 5] body_twist: frame: not allowed with body_twist"),
        # composite_mode: one dimension, no source
        (
            COMPOSITE | {"range": [0, 1]},
            "slot [0, 1] composite_mode: width: expected 1 dimension(s), got 2",
        ),
        (
            COMPOSITE | {"ee": "g", "frame": "b", "joint_names": ["x"]},
            "slot [0, 0] composite_mode: ee: not allowed with composite_mode\n"
            "slot [0, 0] composite_mode: frame: not allowed with composite_mode\n"
            "slot [0, 0] composite_mode: joint_names: not allowed with composite_mode",
        ),
        # scale and offset
        (
            JOINT | {"scale": [1.0, 1.0, 1.0]},
            "slot [0, 1] joint_velocity: scale: expected 1 or 2 number(s), got 3",
        ),
        (
            JOINT | {"scale": [1.0, 0.0]},
            "slot [0, 1] joint_velocity: scale: expected numbers that are finite and not 0, "
            "got [1.0, 0.0]",
        ),
        (
            JOINT | {"offset": [float("nan"), 0.0]},
            "slot [0, 1] joint_velocity: offset: expected numbers that are finite, got [nan, 0.0]",
        ),
        (
            JOINT | {"scale": float("inf")},
            "slot [0, 1] joint_velocity: scale: expected numbers that are finite "
            "and not 0, got [inf]",
        ),
        (BODY | {"unit": "deg"}, "slot [0, 5] body_twist: unit: not allowed with body_twist"),
        (JOINT | {"scales": 1.0}, "Extra inputs are not permitted"),
    ],
)
def test_a_slot_that_breaks_a_rule_is_refused_by_name(data: dict[str, Any], text: str) -> None:
    prefix = "" if text.startswith(("Extra", "Input")) else "Value error, "
    assert refusal(Slot, data) == prefix + text


def test_body_twist_with_axes_is_as_wide_as_its_axes() -> None:
    assert Slot.model_validate(BODY | {"range": [3, 5], "axes": [0, 1, 5]}).axes == (0, 1, 5)


def test_one_scale_counts_for_every_dimension_and_the_default_is_one_and_zero() -> None:
    assert Slot.model_validate(JOINT | {"scale": 0.5, "offset": -1}).scales() == (0.5, 0.5)
    assert Slot.model_validate(JOINT | {"scale": 0.5, "offset": -1}).offsets() == (-1.0, -1.0)
    assert Slot.model_validate(JOINT | {"scale": [1.0, 1.5]}).scales() == (1.0, 1.5)
    assert Slot.model_validate(JOINT).scales() == (1.0, 1.0)
    assert Slot.model_validate(JOINT).offsets() == (0.0, 0.0)


def contract(dim: int, *slots: dict[str, Any]) -> dict[str, Any]:
    return {"dim": dim, "slots": list(slots)}


def test_ranges_include_both_ends() -> None:
    checked = ActionContract.model_validate(contract(7, CARTESIAN, GRIPPER | {"range": [6, 6]}))
    assert [slot.width for slot in checked.slots] == [6, 1]


def test_discarded_slots_are_not_routed() -> None:
    checked = ActionContract.model_validate(contract(2, DISCARD, COMPOSITE | {"range": [1, 1]}))
    assert [slot.name for slot in checked.routed] == ["slot [1, 1] composite_mode"]


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (contract(2), "slots: expected every index of 0..1 to be covered, got no slots"),
        (
            contract(9, CARTESIAN, GRIPPER | {"range": [7, 7]}),
            "slots: index 6 is covered by no slot (use discard: true)\n"
            "slots: index 8 is covered by no slot (use discard: true)",
        ),
        (
            contract(6, CARTESIAN, GRIPPER | {"range": [5, 5]}),
            "slots: index 5 is covered by slot [0, 5] cartesian_delta and "
            "slot [5, 5] gripper_position",
        ),
        (contract(5, CARTESIAN), "slot [0, 5] cartesian_delta: index 5 is out of range, dim is 5"),
        # an end-exclusive author: [0, 6) written as [0, 6]
        (
            contract(7, POSE, GRIPPER | {"range": [6, 6]}),
            "slots: index 6 is covered by slot [0, 6] cartesian_pose and "
            "slot [6, 6] gripper_position",
        ),
        # nothing is commanded twice
        (
            contract(4, JOINT, JOINT | {"range": [2, 3], "joint_names": ["y", "z"]}),
            "slots: joint y is commanded by 2 slots",
        ),
        (
            contract(2, GRIPPER, GRIPPER | {"range": [1, 1]}),
            "slots: gripper_position of gripper is commanded by 2 slots",
        ),
        (
            contract(2, COMPOSITE, COMPOSITE | {"range": [1, 1]}),
            "slots: composite_mode is commanded by 2 slots",
        ),
    ],
)
def test_slots_that_do_not_cover_exactly_once_are_refused_by_index(
    data: dict[str, Any], text: str
) -> None:
    assert refusal(ActionContract, data) == "Value error, " + text


@pytest.mark.timeout(20)
@pytest.mark.parametrize(
    ("dim", "last", "said"),
    [
        (12, 10**9, "index 12 is out of range, dim is 12"),
        (10**9, 11, "less than or equal to 4096"),
    ],
)
def test_an_absurd_range_or_width_is_refused_at_once(dim: int, last: int, said: str) -> None:
    slot = {"range": [0, last], "discard": True}
    with pytest.raises(ValidationError, match=said):
        ActionContract.model_validate({"dim": dim, "slots": [slot]})


def test_a_vector_of_no_dimensions_is_refused() -> None:
    assert refusal(ActionContract, contract(0, DISCARD)) == "Input should be greater than 0"


def test_gaps_and_overlaps_are_told_beside_a_slots_own_fault() -> None:
    slots = [
        {"range": [0, 2]},
        {"range": [2, 2], "control_mode": "gripper_position"},
        {"range": [4, 4], "discard": True, "ee": "hand"},
    ]
    with pytest.raises(ConfigError) as caught:
        checked_model("rskill.yaml", ActionContract, {"dim": 5, "slots": slots})
    lines = [line.strip() for line in str(caught.value).splitlines()[1:]]
    assert lines[0].startswith(
        "slots.0: slot [0, 2]: expected control_mode or discard: true, got neither (valid: "
    )
    assert lines[1:] == [
        "slots.1: slot [2, 2] gripper_position: ee: required with gripper_position",
        "slots.2: slot [4, 4] discard: ee: not allowed with discard",
        "slots: index 2 is covered by slot [0, 2] and slot [2, 2] gripper_position",
        "slots: index 3 is covered by no slot (use discard: true)",
    ]


@pytest.mark.parametrize("slots", [7, [7], [{}], [{"range": 3}], [{"range": ["a", 1]}]])
def test_slots_that_are_none_are_an_error_and_no_traceback(slots: object) -> None:
    with pytest.raises(ConfigError, match=r"^rskill.yaml: \d+ problem"):
        checked_model("rskill.yaml", ActionContract, {"dim": 5, "slots": slots})
