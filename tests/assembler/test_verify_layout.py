"""Layouts against simulator truth while the robot is driven at random."""

import pytest

from fairlead.cli.verify_layout import FieldReport, verify_layout
from fairlead.errors import LayoutError
from fairlead.skill import SkillManifest, load_skill
from tests.assembler.robot_feed import SKILL


def rebound(**bindings: object) -> SkillManifest:
    """The shipped skill with other bindings."""
    skill = load_skill(SKILL)
    changed = skill.state_contract.bindings.model_copy(update=bindings)
    contract = skill.state_contract.model_copy(update={"bindings": changed})
    return skill.model_copy(update={"state_contract": contract})


def off(reports: list[FieldReport]) -> dict[str, str]:
    return {report.field: report.binding for report in reports if not report.ok}


def test_every_field_of_the_shipped_skill_agrees_while_driving_at_random() -> None:
    reports = verify_layout(load_skill(SKILL), n_ticks=150, seed=4)
    assert off(reports) == {}
    assert [report.field for report in reports] == [
        "base_to_eef position",
        "base_to_eef rotation",
        "world_to_base position",
        "world_to_base rotation",
        "gripper",
        "base_to_object position",
        "base_to_object rotation",
        "base_to_goal position",
        "base_to_goal rotation",
    ]
    assert all(report.worst >= 0.0 for report in reports)


def test_skill_bound_wxyz_agrees_too() -> None:
    assert off(verify_layout(rebound(quaternion_convention="wxyz"), n_ticks=10)) == {}


def test_tool_point_instead_of_the_grip_site_is_named_with_the_frame_that_fits() -> None:
    reports = verify_layout(rebound(eef_frame="panda_hand_tcp"), n_ticks=5)
    assert off(reports) == {
        "base_to_eef position": (
            "eef_frame: panda_hand_tcp or base_frame: base_site is off; "
            "would agree: eef_frame: grip_site"
        )
    }
    [wrong] = [report for report in reports if not report.ok]
    assert wrong.worst == pytest.approx(0.0064, abs=1e-4)


def test_rotation_of_the_grip_site_is_named_as_the_wrong_rotation_frame() -> None:
    found = off(verify_layout(rebound(eef_rotation_frame="grip_site"), n_ticks=5))
    assert list(found) == ["base_to_eef rotation"]
    assert found["base_to_eef rotation"].startswith(
        "eef_rotation_frame: grip_site or base_frame: base_site is off; would agree: "
    )
    assert "eef_rotation_frame: panda_hand" in found["base_to_eef rotation"]


def test_swapped_fingers_are_named() -> None:
    swapped = ("panda_finger_joint2", "panda_finger_joint1")
    assert off(verify_layout(rebound(gripper_qpos_joints=swapped), n_ticks=5)) == {
        "gripper": f"gripper_qpos_joints: {swapped} is off"
    }


def test_frame_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(LayoutError) as error:
        verify_layout(rebound(goal_frame="shelf"), n_ticks=1)
    assert str(error.value).startswith(
        "transforms: no frame 'shelf' (looked up from 'base_site'); known: base_link, base_site"
    )
