"""Layouts against simulator truth while the robot is driven at random."""

import pytest

from fairlead.errors import ConfigError, LayoutError
from fairlead.skill.manifest import load_skill
from fairlead.skill.state_contract import StateContract
from fairlead_tools.parity.layout_comparison import FieldReport, verify_layout
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS
from tests.assembler.robot_feed import SKILL

pytestmark = pytest.mark.simulator

ROBOT = "panda_mobile"


def shipped(**bindings: object) -> StateContract:
    """The shipped skill's contract with other bindings."""
    return rebound(load_skill(SKILL).state_contract, **bindings)


def example(layout: str, **bindings: object) -> StateContract:
    """The contract of a layout's own example."""
    made = LAYOUTS[layout].example
    return rebound(StateContract(layout=layout, dim=LAYOUT_DIMS[layout], bindings=made), **bindings)


def rebound(contract: StateContract, **bindings: object) -> StateContract:
    changed = contract.bindings.model_copy(update=bindings)
    return contract.model_copy(update={"bindings": changed})


def off(reports: list[FieldReport]) -> dict[str, str]:
    return {report.field: report.binding for report in reports if not report.ok}


def test_every_field_of_the_shipped_skill_agrees_while_driving_at_random() -> None:
    reports = verify_layout(shipped(), ROBOT, n_ticks=150, seed=4)
    assert off(reports) == {}
    assert [report.field for report in reports] == [
        "base_to_eef position",
        "base_to_eef rotation",
        "odom_to_base position",
        "odom_to_base rotation",
        "gripper",
        "base_to_object position",
        "base_to_object rotation",
        "base_to_goal position",
        "base_to_goal rotation",
    ]
    assert all(report.worst >= 0.0 for report in reports)


@pytest.mark.parametrize("skill", ["pi05-robocasa365-human300-nf4", "rldx-robocasa"])
def test_checkpoints_base_is_in_the_simulators_world_wherever_it_starts(skill: str) -> None:
    contract = load_skill(skill).state_contract
    assert off(verify_layout(contract, ROBOT, n_ticks=20, seed=1)) == {}


def test_base_in_odom_is_named_as_the_wrong_world_with_the_frame_that_fits() -> None:
    found = off(verify_layout(example("human300_16d", world_frame="odom"), ROBOT, n_ticks=5))
    assert found == {
        f"world_to_base {what}": (
            "world_frame: odom or base_frame: base_site is off; would agree: world_frame: map"
        )
        for what in ("position", "rotation")
    }


def test_skill_bound_wxyz_agrees_too() -> None:
    assert off(verify_layout(shipped(quaternion_convention="wxyz"), ROBOT, n_ticks=10)) == {}


def test_tool_point_instead_of_the_grip_site_is_named_with_the_frame_that_fits() -> None:
    reports = verify_layout(shipped(eef_frame="panda_hand_tcp"), ROBOT, n_ticks=5)
    assert off(reports) == {
        "base_to_eef position": (
            "eef_frame: panda_hand_tcp or base_frame: base_site is off; "
            "would agree: eef_frame: grip_site"
        )
    }
    [wrong] = [report for report in reports if not report.ok]
    assert wrong.worst == pytest.approx(0.0064, abs=1e-4)


def test_rotation_of_the_grip_site_is_named_as_the_wrong_rotation_frame() -> None:
    found = off(verify_layout(shipped(eef_rotation_frame="grip_site"), ROBOT, n_ticks=5))
    assert list(found) == ["base_to_eef rotation"]
    assert found["base_to_eef rotation"].startswith(
        "eef_rotation_frame: grip_site or base_frame: base_site is off; would agree: "
    )
    assert "eef_rotation_frame: panda_hand" in found["base_to_eef rotation"]


def test_swapped_fingers_are_named() -> None:
    swapped = ("panda_finger_joint2", "panda_finger_joint1")
    assert off(verify_layout(shipped(gripper_qpos_joints=swapped), ROBOT, n_ticks=5)) == {
        "gripper": f"gripper_qpos_joints: {swapped} is off"
    }


def test_frame_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(LayoutError) as error:
        verify_layout(shipped(goal_frame="shelf"), ROBOT, n_ticks=1)
    assert str(error.value).startswith(
        "transforms: no frame 'shelf' (looked up from 'base_site'); known: base_link, base_site"
    )


VERIFIABLE: tuple[str, ...] = (
    "human300_16d",
    "rc365",
    "libero_eef8d",
    "libero",
    "panda_omron_53d",
)


@pytest.mark.parametrize("layout", VERIFIABLE)
def test_example_of_every_layout_of_this_robot_agrees_while_driving_at_random(
    layout: str,
) -> None:
    reports = verify_layout(example(layout), ROBOT, n_ticks=30, seed=4)
    assert off(reports) == {}
    assert all(0.0 <= report.worst <= report.allowed for report in reports)


def test_every_other_layout_is_for_another_robot_or_verified_above() -> None:
    assert set(LAYOUTS) - set(VERIFIABLE) == {*("mobile_pick_30d", "base_pose_6d", "aloha", "gr1")}


def test_sign_bound_for_libero_is_the_simulators_in_every_tick_and_w_is_not() -> None:
    [_, bound, _] = verify_layout(example("libero_eef8d"), ROBOT, n_ticks=40, seed=0)
    canonical = example("libero_eef8d", quaternion_signs={})
    [_, other, _] = verify_layout(canonical, ROBOT, n_ticks=40, seed=0)
    assert (bound.ok, bound.other_sign_ticks) == (True, 0)
    assert other.ok
    assert 0 < other.other_sign_ticks < 40  # it changes on the way: the vector would jump


def test_wrong_frames_of_libero_eef8d_are_named_with_those_that_fit() -> None:
    wrong = example("libero_eef8d", eef_rotation_frame="base_site")
    found = off(verify_layout(wrong, ROBOT, n_ticks=5))
    assert list(found) == ["world_to_eef rotation"]
    assert (
        "eef_rotation_frame: base_site or world_frame: map is off"
        in (found["world_to_eef rotation"])
    )
    assert "eef_rotation_frame: panda_hand" in found["world_to_eef rotation"]


def test_joints_in_another_order_are_named() -> None:
    names = tuple(f"panda_joint{number}" for number in (2, 1, 3, 4, 5, 6, 7))
    found = off(verify_layout(example("libero", joint_names=names), ROBOT, n_ticks=5))
    assert found == {"arm joints": f"joint_names: {names} is off"}


def test_total_opening_mirrored_is_not_what_the_fingers_measure() -> None:
    record = example("human300_16d", gripper_qpos_joints=("panda_gripper",))
    assert off(verify_layout(record, ROBOT, n_ticks=5)) == {
        "gripper": "gripper_qpos_joints: ('panda_gripper',) is off"
    }


def test_one_finger_mirrored_agrees_at_rest() -> None:
    one = example("human300_16d", gripper_qpos_joints=("panda_finger_joint1",))
    assert off(verify_layout(one, ROBOT, n_ticks=1)) == {}


@pytest.mark.parametrize("layout", ["aloha", "gr1"])
def test_layout_the_simulator_cannot_judge_is_refused(layout: str) -> None:
    contract = StateContract.model_construct(layout=layout, dim=14)
    with pytest.raises(ConfigError) as error:
        verify_layout(contract, ROBOT, n_ticks=1)
    assert str(error.value) == (
        f"layout verify: layout {layout} names no fields that the simulator knows the truth of"
    )


def test_fields_that_an_arm_on_a_table_does_not_have_are_named() -> None:
    with pytest.raises(ConfigError) as error:
        verify_layout(example("human300_16d"), "ur5e", n_ticks=1)
    assert "got one of UR5e without base_to_eef position" in str(error.value)
