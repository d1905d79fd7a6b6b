"""What holds for every pose, every joint order and every binding of every layout."""

from typing import get_args

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robosuite.utils.transform_utils import quat2axisangle

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray
from fairlead.skill.bindings import QuaternionSign, StateContractBindings
from fairlead_state_assembler import (
    JointPositions,
    TransformBuffer,
    assemble_state,
    pose_from,
)
from fairlead_state_assembler.pose_vector import axis_angle3, quaternion_xyzw, rotation4
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS

SIGNS: tuple[QuaternionSign, ...] = get_args(QuaternionSign)
ASSEMBLED = tuple(LAYOUT_DIMS)
TASK_SPACE = tuple(name for name in ASSEMBLED if LAYOUTS[name].required)
FRAMES = ("grip_site", "panda_hand", "base_site", "base_link", "object", "goal")

numbers = st.floats(-10.0, 10.0, allow_subnormal=False)
quaternions = (
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4)
    .map(np.array)
    .filter(lambda q: bool(np.linalg.norm(q) > 0.1))
    .map(lambda q: q / np.linalg.norm(q))
)
poses = st.builds(
    lambda xyz, q: pose_from("any", xyz, q), st.lists(numbers, min_size=3, max_size=3), quaternions
)
layouts = st.sampled_from(ASSEMBLED)
trees = st.fixed_dictionaries(dict.fromkeys(FRAMES, poses))
"""T_odom_frame of every frame."""


def buffer_of(tree: dict[str, pin.SE3], world: pin.SE3 | None = None) -> TransformBuffer:
    buffer = TransformBuffer()
    buffer.add("map", "odom", world or pin.SE3.Identity(), 1, is_static=True)
    for frame, pose in tree.items():
        buffer.add("odom", frame, pose, 1, is_static=False)
    return buffer


def joints_of(layout: str, bindings: StateContractBindings) -> list[str]:
    found = LAYOUTS[layout]
    return [*found.bound_joints(bindings), *found.bound_gripper(bindings)]


def measured(names: list[str]) -> JointPositions:
    """Each joint at a position and velocity of its own, whatever the order of the names."""
    numbers = np.array([float(sum(name.encode())) for name in names])
    return JointPositions.named(names, numbers, numbers / 7)


def assembled(layout: str, bindings: StateContractBindings, buffer: TransformBuffer) -> FloatArray:
    joints = measured(joints_of(layout, bindings))
    return assemble_state(layout, bindings, joints, buffer.at(1))


@given(quaternions, st.sampled_from(SIGNS))
def test_quaternion_is_the_same_rotation_with_the_sign_asked_for(
    xyzw: FloatArray, sign: QuaternionSign
) -> None:
    got = quaternion_xyzw(pose_from("any", [0, 0, 0], xyzw), sign)
    assert np.isclose(np.linalg.norm(got), 1.0, atol=1e-12)
    assert np.isclose(abs(got @ xyzw), 1.0, atol=1e-12)
    decides = got["xyzw".index(sign[1])]
    assert decides >= 0.0 if sign[0] == "+" else decides <= 0.0


@given(quaternions, st.sampled_from(SIGNS))
def test_quaternion_does_not_depend_on_the_sign_it_came_with(
    xyzw: FloatArray, sign: QuaternionSign
) -> None:
    one, other = pose_from("any", [0, 0, 0], xyzw), pose_from("any", [0, 0, 0], -xyzw)
    assert np.array_equal(quaternion_xyzw(one, sign), quaternion_xyzw(other, sign))


@given(poses, st.sampled_from(SIGNS))
def test_wxyz_is_xyzw_turned_by_one(pose: pin.SE3, sign: QuaternionSign) -> None:
    x, y, z, w = rotation4(pose, "xyzw", sign)
    assert rotation4(pose, "wxyz", sign).tolist() == [w, x, y, z]


@given(poses)
def test_axis_angle_with_positive_w_is_the_logarithm_of_the_rotation(pose: pin.SE3) -> None:
    vector = axis_angle3(pose, "+w")
    assert np.linalg.norm(vector) <= np.pi + 1e-12
    assert np.allclose(pin.exp3(vector), pose.rotation, atol=1e-9)


@given(poses, st.sampled_from(SIGNS))
def test_axis_angle_is_robosuites_of_the_same_quaternion(
    pose: pin.SE3, sign: QuaternionSign
) -> None:
    xyzw = quaternion_xyzw(pose, sign)
    if 1.0 - abs(xyzw[3]) < 1e-9:
        return  # robosuite's formula cancels there: it is no reference
    assert np.allclose(axis_angle3(pose, sign), quat2axisangle(xyzw.copy()), atol=1e-6)


def test_no_rotation_has_no_axis_whatever_the_sign() -> None:
    for sign in SIGNS:
        assert axis_angle3(pin.SE3.Identity(), sign).tolist() == [0.0, 0.0, 0.0]


@given(layouts, trees)
def test_assembling_twice_gives_the_same_bits_and_changes_no_input(
    layout: str, tree: dict[str, pin.SE3]
) -> None:
    bindings, buffer = LAYOUTS[layout].example, buffer_of(tree)
    before = {frame: pose.homogeneous.tobytes() for frame, pose in tree.items()}
    values = assembled(layout, bindings, buffer)
    assert values.shape == (LAYOUT_DIMS[layout],)
    assert values.dtype == np.float64
    kept = values.tobytes()
    values[:] = -1.0  # the caller's own copy
    assert assembled(layout, bindings, buffer).tobytes() == kept
    assert {frame: pose.homogeneous.tobytes() for frame, pose in tree.items()} == before


@given(layouts, trees, st.randoms(use_true_random=False))
def test_order_and_number_of_the_robots_joints_do_not_matter(
    layout: str, tree: dict[str, pin.SE3], random: object
) -> None:
    bindings, view = LAYOUTS[layout].example, buffer_of(tree).at(1)
    names = [*joints_of(layout, bindings), "torso", "base_x"]
    shuffled = list(names)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert np.array_equal(
        assemble_state(layout, bindings, measured(names), view),
        assemble_state(layout, bindings, measured(shuffled), view),
    )


@given(st.sampled_from(["human300_16d", "mobile_pick_30d"]), trees, poses)
def test_moving_robot_and_object_together_changes_only_the_base_in_the_world(
    layout: str, tree: dict[str, pin.SE3], moved: pin.SE3
) -> None:
    bindings = LAYOUTS[layout].example
    here = assembled(layout, bindings, buffer_of(tree))
    there = assembled(layout, bindings, buffer_of({f: moved * pose for f, pose in tree.items()}))
    quaternions_at = [3, *([19, 26] if layout == "mobile_pick_30d" else [])]
    for first in quaternions_at:  # beside w = 0 rounding may choose the other sign
        assert np.isclose(abs(here[first : first + 4] @ there[first : first + 4]), 1.0)
    plain = [0, 1, 2, 14, 15, *([16, 17, 18, 23, 24, 25] if len(here) == 30 else [])]
    assert np.allclose(here[plain], there[plain], atol=1e-9)


@given(trees, poses)
def test_human300_16d_gives_the_tree_back(tree: dict[str, pin.SE3], world: pin.SE3) -> None:
    bindings = LAYOUTS["human300_16d"].example.model_copy(update={"world_frame": "map"})
    values = assembled("human300_16d", bindings, buffer_of(tree, world))
    T_map_base = pose_from("base", values[7:10], values[10:14])
    eef = T_map_base * pose_from("eef", values[0:3], values[3:7])
    assert np.allclose(eef.translation, (world * tree["grip_site"]).translation, atol=1e-9)
    assert np.allclose(eef.rotation, (world * tree["panda_hand"]).rotation, atol=1e-9)


@given(trees)
def test_libero_eef8d_is_the_eef_of_human300_16d_in_a_base_that_is_the_world(
    tree: dict[str, pin.SE3],
) -> None:
    world = LAYOUTS["human300_16d"].example.model_copy(update={"base_frame": "odom"})
    human300 = assembled("human300_16d", world, buffer_of(tree))
    libero = assembled("libero_eef8d", world, buffer_of(tree))
    assert np.array_equal(libero[:3], human300[:3])
    rotation = pose_from("eef", [0, 0, 0], human300[3:7]).rotation
    assert np.allclose(pin.exp3(libero[3:6]), rotation, atol=1e-9)
    assert np.array_equal(libero[6:], human300[14:])


@pytest.mark.parametrize("layout", TASK_SPACE)
@given(tree=trees, data=st.data())
def test_any_frame_that_is_gone_is_an_error_naming_it(
    layout: str, tree: dict[str, pin.SE3], data: st.DataObject
) -> None:
    bindings = LAYOUTS[layout].example
    used = [name for name in LAYOUTS[layout].required if name.endswith("_frame")]
    if "eef_frame" in used:
        used.append("eef_rotation_frame")
    gone = data.draw(st.sampled_from(used))
    changed = bindings.model_copy(update={gone: "gone"})
    with pytest.raises(LayoutError) as error:
        assembled(layout, changed, buffer_of(tree))
    assert error.value.kind == "missing_frame"
    assert "gone" in (error.value.name, error.value.parent)


@pytest.mark.parametrize("layout", sorted(set(ASSEMBLED) - {"base_pose_6d"}))  # which reads none
@given(data=st.data())
def test_any_joint_that_is_gone_is_an_error_naming_it(layout: str, data: st.DataObject) -> None:
    bindings = LAYOUTS[layout].example
    names = joints_of(layout, bindings)
    gone = data.draw(st.sampled_from(names))
    left = measured([name for name in names if name != gone])
    view = buffer_of(dict.fromkeys(FRAMES, pin.SE3.Identity())).at(1)
    with pytest.raises(LayoutError) as error:
        assemble_state(layout, bindings, left, view)
    assert (error.value.kind, error.value.name) == ("missing_joint", gone)


@pytest.mark.parametrize("layout", ASSEMBLED)
def test_a_binding_changes_the_vector_exactly_if_the_layout_says_that_it_reads_it(
    layout: str,
) -> None:
    """What it does not read is refused in a skill: what it reads must not be."""
    turns = [np.array([0.1 + i, 0.2, -0.3 * i, 0.5]) for i in range(7)]
    tree = {
        frame: pose_from("any", [i, 2 * i, 1], turn / np.linalg.norm(turn))
        for i, (frame, turn) in enumerate(zip([*FRAMES, "elsewhere"], turns, strict=True))
    }
    fingers, own = ("panda_finger_joint1", "panda_finger_joint2"), LAYOUTS[layout].joint_names
    bound = StateContractBindings(
        eef_frame="grip_site", eef_rotation_frame="panda_hand", base_frame="base_site",
        object_frame="object", goal_frame="goal", gripper_qpos_joints=fingers, joint_names=own,
    )  # fmt: skip
    changes = dict.fromkeys(
        [name for name in StateContractBindings.model_fields if name.endswith("_frame")],
        "elsewhere",
    ) | {
        "gripper_qpos_joints": fingers[::-1],
        "joint_names": own[::-1],
        "quaternion_convention": "wxyz",
        "quaternion_signs": dict.fromkeys(
            ("eef_frame", "base_frame", "object_frame", "goal_frame"), "-w"
        ),
    }  # fmt: skip
    assert changes.keys() == StateContractBindings.model_fields.keys()
    buffer, joints = buffer_of(tree), measured([*own, *fingers])
    before = assemble_state(layout, bound, joints, buffer.at(1))
    changed = {
        name
        for name, value in changes.items()
        if not np.array_equal(
            before,
            assemble_state(layout, bound.model_copy(update={name: value}), joints, buffer.at(1)),
        )
    }
    assert changed == set(LAYOUTS[layout].read)
