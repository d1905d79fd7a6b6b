"""Layouts as pure functions: values, order, sign, and what is refused."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from fairlead.errors import LayoutError
from fairlead.layout import LayoutInputs
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler import JointPositions, assemble_state, pose_from, registry
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS
from tests.assembler.fixed_transforms import FixedTransforms

BINDINGS = StateContractBindings(
    eef_frame="grip_site",
    eef_rotation_frame="panda_hand",
    base_frame="base_site",
    world_frame="map",
    gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    object_frame="object",
    goal_frame="goal",
)
JOINTS = JointPositions.named(
    ("panda_finger_joint1", "panda_finger_joint2"), np.array([0.02, -0.03])
)
HALF = float(np.sqrt(0.5))
POSES = {
    ("base_site", "grip_site"): pose_from("grip_site", [0.5, 0.1, 0.2], [0.0, 0.0, 0.0, 1.0]),
    ("base_site", "panda_hand"): pose_from("panda_hand", [9.0, 9.0, 9.0], [HALF, 0.0, 0.0, HALF]),
    ("map", "grip_site"): pose_from("grip_site", [3.0, 2.0, 1.0], [0.0, 0.0, 0.0, 1.0]),
    ("map", "panda_hand"): pose_from("panda_hand", [9.0, 9.0, 9.0], [0.8, 0.0, 0.0, -0.6]),
    ("map", "base_site"): pose_from("base_site", [1.0, 2.0, 0.9], [0.0, 0.0, HALF, HALF]),
    ("odom", "base_site"): pose_from("base_site", [0.5, 0.0, 0.9], [0.0, 0.0, 0.6, 0.8]),
    ("base_site", "object"): pose_from("object", [0.6, 0.0, 0.1], [0.0, 0.0, 0.6, 0.8]),
    ("base_site", "goal"): pose_from("goal", [0.7, 0.3, 0.4], [0.0, 0.6, 0.0, -0.8]),
}
POSES["map", "odom"] = POSES["map", "base_site"] * POSES["odom", "base_site"].inverse()


def test_human300_16d_is_eef_in_base_then_base_in_world_then_fingers() -> None:
    values = assemble_state("human300_16d", BINDINGS, JOINTS, FixedTransforms(POSES))
    wanted = [0.5, 0.1, 0.2, HALF, 0, 0, HALF, 1, 2, 0.9, 0, 0, HALF, HALF, 0.02, -0.03]
    assert values.dtype == np.float64
    assert np.allclose(values, wanted, atol=1e-12)


def test_mobile_pick_30d_adds_object_and_goal_in_the_base_with_positive_w() -> None:
    values = assemble_state("mobile_pick_30d", BINDINGS, JOINTS, FixedTransforms(POSES))
    assert np.array_equal(
        values[:16], assemble_state("human300_16d", BINDINGS, JOINTS, FixedTransforms(POSES))
    )
    assert np.allclose(values[16:23], [0.6, 0.0, 0.1, 0.0, 0.0, 0.6, 0.8], atol=1e-12)
    assert np.allclose(values[23:], [0.7, 0.3, 0.4, 0.0, -0.6, 0.0, 0.8], atol=1e-12)


def test_rotation_comes_from_the_eef_frame_where_no_other_is_bound() -> None:
    bindings = BINDINGS.model_copy(update={"eef_rotation_frame": None})
    values = assemble_state("human300_16d", bindings, JOINTS, FixedTransforms(POSES))
    assert np.allclose(values[:7], [0.5, 0.1, 0.2, 0.0, 0.0, 0.0, 1.0], atol=1e-12)


def test_wxyz_puts_w_first_in_every_quaternion() -> None:
    bindings = BINDINGS.model_copy(update={"quaternion_convention": "wxyz"})
    xyzw = assemble_state("mobile_pick_30d", BINDINGS, JOINTS, FixedTransforms(POSES))
    wxyz = assemble_state("mobile_pick_30d", bindings, JOINTS, FixedTransforms(POSES))
    moved = xyzw.copy()
    for first in (3, 10, 19, 26):
        moved[first : first + 4] = np.roll(xyzw[first : first + 4], 1)
    assert np.array_equal(wxyz, moved)


def test_one_gripper_joint_is_mirrored() -> None:
    bindings = BINDINGS.model_copy(update={"gripper_qpos_joints": ("panda_finger_joint1",)})
    values = assemble_state("human300_16d", bindings, JOINTS, FixedTransforms(POSES))
    assert values[14:].tolist() == [0.02, -0.02]


def test_unknown_gripper_joint_is_named_with_the_known_ones() -> None:
    bindings = BINDINGS.model_copy(update={"gripper_qpos_joints": ("left_finger",)})
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", bindings, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == (
        "joint state: no joint 'left_finger' (valid: panda_finger_joint1, panda_finger_joint2)"
    )
    assert (error.value.kind, error.value.name) == ("missing_joint", "left_finger")


@pytest.mark.parametrize("names", [(), ("a", "b", "c")])
def test_any_other_number_of_gripper_joints_is_refused(names: tuple[str, ...]) -> None:
    bindings = BINDINGS.model_copy(update={"gripper_qpos_joints": names})
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", bindings, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == (
        f"gripper_qpos_joints: expected one or two joints, got {list(names)}"
    )


@pytest.mark.parametrize("binding", ["eef_frame", "base_frame", "world_frame"])
def test_missing_binding_is_named(binding: str) -> None:
    bindings = BINDINGS.model_copy(update={binding: None})
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", bindings, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == f"layout human300_16d: the bindings name no {binding}"
    assert (error.value.kind, error.value.name) == ("missing_frame", binding)


def test_missing_frame_is_an_error_and_never_a_zero_fill() -> None:
    poses = {key: value for key, value in POSES.items() if key[1] != "goal"}
    with pytest.raises(LayoutError) as error:
        assemble_state("mobile_pick_30d", BINDINGS, JOINTS, FixedTransforms(poses))
    assert (error.value.kind, error.value.name, error.value.parent) == (
        "missing_frame", "goal", "base_site",
    )  # fmt: skip


def test_number_that_is_not_finite_is_an_error_naming_its_index() -> None:
    joints = JointPositions.named(
        ("panda_finger_joint1", "panda_finger_joint2"), np.array([0.02, np.nan])
    )
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", BINDINGS, joints, FixedTransforms(POSES))
    assert str(error.value) == "layout human300_16d: index 15 is not finite: nan"
    assert error.value.kind == "not_finite"


def test_numbers_whose_sum_is_not_finite_are_finite_still() -> None:
    fingers = np.array([1.7e308, 1.7e308])
    joints = JointPositions.named(("panda_finger_joint1", "panda_finger_joint2"), fingers)
    values = assemble_state("human300_16d", BINDINGS, joints, FixedTransforms(POSES))
    assert values[14:].tolist() == fingers.tolist()


def test_layout_without_an_assembler_says_where_those_are_that_have_one() -> None:
    with pytest.raises(LayoutError) as error:
        assemble_state("gr1", BINDINGS, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == ("layout gr1: no assembler; those that have one: fairlead layout ls")
    assert (error.value.kind, error.value.name) == ("no_assembler", "gr1")


def test_every_declared_layout_has_an_assembler_of_its_width() -> None:
    for layout, dim in LAYOUT_DIMS.items():
        joints = (*LAYOUTS[layout].bound_joints(BINDINGS), *BINDINGS.gripper_qpos_joints)
        measured = JointPositions.named(joints, np.zeros(len(joints)), np.zeros(len(joints)))
        values = assemble_state(layout, BINDINGS, measured, FixedTransforms(POSES))
        assert values.shape == (dim,)
        assert values.dtype == np.float64


def test_base_pose_6d_is_x_y_and_yaw_in_the_world_and_in_odom() -> None:
    values = assemble_state("base_pose_6d", BINDINGS, JOINTS, FixedTransforms(POSES))
    wanted = [1.0, 2.0, np.pi / 2, 0.5, 0.0, 2 * np.arctan2(0.6, 0.8)]
    assert np.allclose(values, wanted, atol=1e-12)


def test_panda_omron_53d_is_human300_16d_with_fingers_first_then_what_gr00t_wants_besides() -> None:
    names = [*(f"panda_joint{number}" for number in range(1, 8)), *BINDINGS.gripper_qpos_joints]
    q, v = np.arange(1.0, 8.0), np.arange(11.0, 18.0)
    joints = JointPositions.named(names, np.append(q, [0.02, -0.03]), np.append(v, [0.5, 0.6]))
    hand = POSES["map", "base_site"] * POSES["base_site", "panda_hand"]
    poses = FixedTransforms(POSES | {("map", "panda_hand"): hand})
    values = assemble_state("panda_omron_53d", BINDINGS, joints, poses)
    human300 = assemble_state("human300_16d", BINDINGS, joints, FixedTransforms(POSES))
    assert np.array_equal(values[:16], np.concatenate((human300[14:], human300[:14])))
    assert values[16:18].tolist() == [0.5, 0.6]
    assert np.allclose(values[18:25], [3.0, 2.0, 1.0, 0.5, 0.5, 0.5, 0.5], atol=1e-12)
    assert np.allclose(values[25:], np.concatenate((q, np.cos(q), np.sin(q), v)), atol=1e-12)


LIBERO = BINDINGS.model_copy(update={"base_frame": None})


def test_libero_eef8d_is_eef_in_the_world_with_axis_angle_then_fingers() -> None:
    values = assemble_state("libero_eef8d", LIBERO, JOINTS, FixedTransforms(POSES))
    turned = -2.0 * np.arctan2(0.8, 0.6)  # w >= 0, so the axis is -x
    assert np.allclose(values, [3, 2, 1, turned, 0, 0, 0.02, -0.03], atol=1e-12)


def test_libero_eef8d_with_x_bound_positive_turns_further_than_half_way() -> None:
    bindings = LIBERO.model_copy(update={"quaternion_signs": {"eef_frame": "+x"}})
    values = assemble_state("libero_eef8d", bindings, JOINTS, FixedTransforms(POSES))
    assert np.allclose(values[3:6], [2.0 * (np.pi - np.arctan2(0.8, 0.6)), 0, 0], atol=1e-12)


def test_sign_bound_to_one_frame_leaves_the_others_alone() -> None:
    bindings = BINDINGS.model_copy(update={"quaternion_signs": {"goal_frame": "-w"}})
    plain = assemble_state("mobile_pick_30d", BINDINGS, JOINTS, FixedTransforms(POSES))
    signed = assemble_state("mobile_pick_30d", bindings, JOINTS, FixedTransforms(POSES))
    assert np.array_equal(signed[26:], -plain[26:])
    assert np.array_equal(signed[:26], plain[:26])


def test_rc365_is_human300_16d_bit_for_bit() -> None:
    rc365 = assemble_state("rc365", BINDINGS, JOINTS, FixedTransforms(POSES))
    human300 = assemble_state("human300_16d", BINDINGS, JOINTS, FixedTransforms(POSES))
    assert rc365.tobytes() == human300.tobytes()


NOTHING_BOUND = StateContractBindings()
NO_TRANSFORMS = FixedTransforms({})


def test_libero_unbound_is_frankas_joints_then_its_fingers_wherever_they_are_measured() -> None:
    joints = JointPositions.named(
        (
            *LAYOUTS["libero"].gripper_qpos_joints,
            "base_x",
            *reversed(LAYOUTS["libero"].joint_names),
        ),
        np.array([0.01, -0.02, 99.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]),
    )
    values = assemble_state("libero", NOTHING_BOUND, joints, NO_TRANSFORMS)
    assert values.tolist() == [1, 2, 3, 4, 5, 6, 7, 0.01, -0.02]


def test_aloha_unbound_is_left_arm_left_gripper_right_arm_right_gripper() -> None:
    names = [
        f"{side}_{joint}"
        for side in ("left", "right")
        for joint in (
            *("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate"),
            "gripper",
        )
    ]
    joints = JointPositions.named(names, np.arange(14.0))
    values = assemble_state("aloha", NOTHING_BOUND, joints, NO_TRANSFORMS)
    assert values.tolist() == list(range(14))


def test_joint_space_layout_takes_the_joints_bound_in_their_order() -> None:
    names = tuple("gfedcba")
    bindings = NOTHING_BOUND.model_copy(
        update={"joint_names": names, "gripper_qpos_joints": ("thumb",)}
    )
    joints = JointPositions.named((*"abcdefg", "thumb"), np.arange(8.0))
    values = assemble_state("libero", bindings, joints, NO_TRANSFORMS)
    assert values.tolist() == [6, 5, 4, 3, 2, 1, 0, 7, -7]


@pytest.mark.parametrize(("layout", "first"), [("libero", "panda_joint1"), ("aloha", "left_waist")])
def test_joint_space_layout_never_guesses_at_joints_of_other_names(layout: str, first: str) -> None:
    # As many as aloha wants, but not those.
    joints = JointPositions.named([f"j{number}" for number in range(14)], np.zeros(14))
    with pytest.raises(LayoutError) as error:
        assemble_state(layout, NOTHING_BOUND, joints, NO_TRANSFORMS)
    assert (error.value.kind, error.value.name) == ("missing_joint", first)


def broken(monkeypatch: pytest.MonkeyPatch, assemble: Callable[[LayoutInputs], object]) -> None:
    """human300_16d with another function."""
    changed = replace(LAYOUTS["human300_16d"], assemble=cast("Any", assemble))
    monkeypatch.setattr(registry, "load_layout", lambda name: changed)


def test_assembler_of_the_wrong_width_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch, lambda at: np.zeros(15))
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", BINDINGS, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == "layout human300_16d: expected 16 numbers, got (15,)"
    assert (error.value.kind, error.value.name) == ("wrong_width", "human300_16d")


@pytest.mark.parametrize(
    ("assemble", "said"),
    [
        (lambda at: 1 / 0, "ZeroDivisionError: division by zero"),
        (
            lambda at: getattr(at, "no \udc80"),
            "AttributeError: 'BoundInputs' object has no attribute 'no \\udc80'",
        ),
    ],
)
def test_assembler_that_raises_is_an_error_of_its_layout(
    assemble: Callable[[LayoutInputs], object], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken(monkeypatch, assemble)
    with pytest.raises(LayoutError) as error:
        assemble_state("human300_16d", BINDINGS, JOINTS, FixedTransforms(POSES))
    assert str(error.value) == f"layout human300_16d: its function failed: {said}"
    assert (error.value.kind, error.value.name) == ("failed", "human300_16d")


@pytest.mark.processes
def test_public_face_is_free_of_zenoh() -> None:
    import subprocess
    import sys

    code = "import sys, fairlead_state_assembler; sys.exit('zenoh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
