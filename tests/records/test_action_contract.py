"""The action vector: what a manifest may say about its 12 numbers, and what is refused."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from fairlead.errors import ConfigError
from fairlead.messages import ActionChunk, decode, floats
from fairlead.modes import ControlMode
from fairlead.paths import rskill_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.candidate import dispatch
from tests.repo.tree import ROOT
from tests.skill.mobile_hal import HAL

MANIFESTS = (
    "rldx1-ft-rc365-nf4",
    "rldx-robocasa",
    "pi05-robocasa365-human300-nf4",
    "gr00t-robocasa",
)
PI05 = MANIFESTS[2]


def slots_of(name: str) -> list[dict[str, Any]]:
    plain = yaml.safe_load((rskill_dir(name) / "rskill.yaml").read_text())
    slots: list[dict[str, Any]] = plain["action_contract"]["slots"]
    return slots


def contract(slots: list[dict[str, Any]]) -> ActionContract:
    return ActionContract.model_validate({"dim": 12, "slots": slots})


def with_slots(slots: list[dict[str, Any]]) -> SkillManifest:
    return load_skill(PI05).model_copy(update={"action_contract": contract(slots)})


def refusal(slots: list[dict[str, Any]]) -> str:
    """The reasons alone: pydantic's own words repeat what was given."""
    with pytest.raises(ValidationError) as caught:
        contract(slots)
    return "\n".join(error["msg"] for error in caught.value.errors())


@pytest.mark.parametrize("name", MANIFESTS)
def test_action_01_the_manifests_route_the_base_discard_the_torso_and_carry_the_switch(
    name: str,
) -> None:
    """Arm [0,5], gripper [6], base [7,9], torso [10] discarded, switch [11]."""
    slots = load_skill(name).action_contract.slots
    assert [(s.first, s.last, s.control_mode) for s in slots] == [
        (0, 5, "cartesian_delta"),
        (6, 6, "gripper_position"),
        (7, 9, "joint_velocity"),
        (10, 10, None),
        (11, 11, "composite_mode"),
    ]
    assert slots[2].joint_names == ("base_x", "base_y", "base_yaw")


def test_action_02_the_manifests_agree_with_each_other_in_every_dimension() -> None:
    """All four manifests share one action contract: the expert's, with clips and thresholds."""
    first, *others = [load_skill(name).action_contract for name in MANIFESTS]
    assert all(other == first for other in others)
    expert = load_skill("oracle-counter-to-cabinet").action_contract
    plain = [slot.model_copy(update={"clip": None, "threshold": None}) for slot in first.slots]
    assert first.model_copy(update={"slots": tuple(plain)}) == expert


@pytest.mark.parametrize("name", MANIFESTS)
def test_action_03_a_manifest_says_why_a_dimension_is_discarded(name: str) -> None:
    """The manifest says that slot 10 is the torso."""
    text = (rskill_dir(name) / "rskill.yaml").read_text()
    line = next(line for line in text.splitlines() if "range: [10, 10]" in line)
    assert "torso" in line
    assert "pending" not in text.lower()


def test_action_04_no_new_control_mode_was_needed() -> None:
    """No new control mode was needed."""
    assert [mode.yaml_name for mode in ControlMode] == [
        "joint_position", "joint_velocity", "joint_torque", "joint_trajectory",
        "cartesian_pose", "cartesian_delta", "cartesian_twist", "body_twist", "foot_placement",
        "gripper_binary", "gripper_position", "dex_hand_joint", "composite_mode",
    ]  # fmt: skip
    base = [*slots_of(PI05)[:2], {"range": [7, 10], "control_mode": "mobile_base_delta"}]
    assert "got 'mobile_base_delta' (valid: " in refusal([*base, slots_of(PI05)[4]])


def test_action_05_every_dimension_is_routed_or_discarded_by_name() -> None:
    """A gap, an overlap, an index out of range is refused by index."""
    slots = slots_of(PI05)
    gap = refusal([s for s in slots if s["range"] != [10, 10]])
    assert "index 10 is covered by no slot (use discard: true)" in gap
    overlap = refusal([*slots, {"range": [9, 9], "discard": True}])
    assert "index 9 is covered by slot [7, 9] joint_velocity and slot [9, 9] discard" in overlap
    outside = refusal([*slots, {"range": [12, 12], "discard": True}])
    assert "index 12 is out of range, dim is 12" in outside


def test_action_06_a_discard_says_nothing_else() -> None:
    """A discarded slot with a mode, frame or joints is refused."""
    for extra in (
        {"control_mode": "joint_velocity"},
        {"joint_names": ["base_x"]},
        {"ee": "gripper"},
    ):
        slots = [s for s in slots_of(PI05) if s["range"] != [10, 10]]
        said = refusal([*slots, {"range": [10, 10], "discard": True} | extra])
        assert f"{next(iter(extra))}: not allowed with discard" in said


@pytest.mark.parametrize("field", ["ee", "frame", "joint_names"])
def test_action_07_the_switch_is_one_number_without_end_effector_frame_or_joints(
    field: str,
) -> None:
    """composite_mode is one number, without tool, frame or joints."""
    value: object = ["base_x"] if field == "joint_names" else "gripper"
    slots = [s for s in slots_of(PI05) if s["range"] != [11, 11]]
    switch = {"range": [11, 11], "control_mode": "composite_mode"}
    assert f"{field}: not allowed with composite_mode" in refusal([*slots, switch | {field: value}])
    wide = [s for s in slots if s["range"] != [10, 10]]
    said = refusal([*wide, switch | {"range": [10, 11]}])
    assert "width: expected 1 dimension(s), got 2" in said


def test_action_08_the_switch_is_mode_12_on_the_wire_in_both_languages() -> None:
    """composite_mode is 12 in Python, C++ and golden messages."""
    assert int(ControlMode.COMPOSITE_MODE) == 12 and ControlMode.COMPOSITE_MODE.width(11) == 1
    header = (ROOT / "services/safety/include/fairlead_safety/modes.hpp").read_text()
    in_cpp = dict(re.findall(r"^  (\w+) = (\d+),", header, re.MULTILINE))
    assert in_cpp == {mode.yaml_name: str(int(mode)) for mode in ControlMode}
    golden = decode(ActionChunk, (ROOT / "tests/golden/ActionChunk.bin").read_bytes())
    assert 12 in [part.mode for part in golden.parts]


def test_action_09_the_robot_offers_joint_velocity_so_the_skill_is_not_dropped(
    robot: RobotManifest,
) -> None:
    """Without joint_velocity of the base the skill is refused."""
    assert admission_problems(load_skill(PI05), robot) == []
    parts = tuple(
        part.model_copy(update={"modes": ("body_twist",)}) if part.name == "base" else part
        for part in robot.parts
    )
    problems = "\n".join(
        admission_problems(load_skill(PI05), robot.model_copy(update={"parts": parts}))
    )
    assert "slot [7, 9] joint_velocity" in problems


def test_action_10_joints_of_two_parts_in_one_slot_are_refused(robot: RobotManifest) -> None:
    """Joints of one slot belong to one part."""
    slots = slots_of(PI05)
    slots[2]["joint_names"] = ["base_x", "base_y", "panda_joint1"]
    problems = "\n".join(admission_problems(with_slots(slots), robot))
    assert "slot [7, 9] joint_velocity: expected exactly one part" in problems


def test_action_11_a_part_of_the_base_goes_to_its_own_joint_only(robot: RobotManifest) -> None:
    """base_yaw alone commands that joint alone."""
    slots = slots_of(PI05)
    slots[2] |= {"range": [7, 7], "joint_names": ["base_yaw"], "scale": 1.5}
    slots[3] |= {"range": [8, 10]}
    skill = with_slots(slots)
    rows = np.zeros((1, 12), dtype=np.float32)
    rows[0, 7] = 0.5
    parts = dispatch(resolve_routes(skill.action_contract, robot), rows, 12)
    base = next(part for part in parts if part.mode == ControlMode.JOINT_VELOCITY)
    assert base.active == (2,)
    assert floats(base.values).tolist() == [0, 0, 0.75] + [0] * 8


def test_action_12_the_base_is_padded_to_the_robots_joints_and_says_which_count(
    robot: RobotManifest,
) -> None:
    """Three base numbers become eleven, zeros elsewhere, with a mask."""
    rows = np.full((2, 12), 0.5, dtype=np.float32)
    parts = dispatch(resolve_routes(load_skill(PI05).action_contract, robot), rows, 12)
    base = next(part for part in parts if part.mode == ControlMode.JOINT_VELOCITY)
    assert base.active == (0, 1, 2)
    assert floats(base.values, 11).tolist() == [[0.5, 0.5, 0.75] + [0.0] * 8] * 2


def test_action_13_joint_names_without_slots_are_mapped_to_the_robots_order(
    robot: RobotManifest,
) -> None:
    """joint_names without slots are mapped to the robot's order."""
    arm = tuple(
        part.model_copy(update={"modes": ("joint_position",)}) if part.name == "arm" else part
        for part in robot.parts
    )
    jointly = robot.model_copy(update={"parts": arm})
    names = tuple(f"panda_joint{n}" for n in (7, 6, 5, 4, 3, 2, 1))
    rows = np.arange(1, 8, dtype=np.float32)[None]
    (part,) = dispatch(resolve_routes(ActionContract(dim=7, joint_names=names), jointly), rows, 7)
    assert floats(part.values)[3:10].tolist() == [7, 6, 5, 4, 3, 2, 1]
    wide = ActionContract(dim=12, joint_names=(*names, *(f"extra{n}" for n in range(5))))
    with pytest.raises(ConfigError, match="at most the 11 joints of robot .*, got dim 12"):
        resolve_routes(wide, jointly)


def test_action_14_a_vector_of_another_width_is_refused_with_both_widths(
    robot: RobotManifest,
) -> None:
    """A vector of another width is refused with both widths."""
    routes = resolve_routes(load_skill(PI05).action_contract, robot)
    with pytest.raises(
        ConfigError, match=r"expected float32 \[H >= 1, 12\], got float32 \[1, 11\]"
    ):
        dispatch(routes, np.zeros((1, 11), dtype=np.float32), 12)


def test_action_15_a_raw_vector_cannot_be_passed_through(robot: RobotManifest) -> None:
    """There is no passthrough of raw vectors."""
    assert "expected every index of 0..11 to be covered, got no slots" in refusal([])
    whole: dict[str, Any] = {"range": [0, 11]}
    assert "expected control_mode or discard: true, got neither" in refusal([whole])
    assert "got 'passthrough'" in refusal([whole | {"control_mode": "passthrough"}])
    arm = {"control_mode": "cartesian_delta", "ee": "gripper", "frame": "base_link"}
    assert "width: expected 6 dimension(s), or axes, got 12" in refusal([whole | arm])


def test_action_16_the_base_is_not_a_body_twist_for_checkpoints(robot: RobotManifest) -> None:
    """Checkpoints drive the base by joint_velocity, not body_twist."""
    for name in MANIFESTS:
        modes = {slot.control_mode for slot in load_skill(name).action_contract.slots}
        assert "body_twist" not in modes
    base = next(part for part in robot.parts if part.name == "base")
    assert set(base.modes) == {"joint_velocity", "body_twist"}


def test_action_17_the_torso_is_no_joint_that_can_be_told(robot: RobotManifest) -> None:
    """No part has the torso; routing to it is refused."""
    assert all("torso_height" not in part.joints for part in robot.parts)
    slots = slots_of(PI05)
    slots[3] = {
        "range": [10, 10],
        "control_mode": "joint_position",
        "joint_names": ["torso_height"],
    }
    problems = "\n".join(admission_problems(with_slots(slots), robot))
    listed = f"has no joint 'torso_height' (valid: {', '.join(robot.joint_names)})"
    assert listed in problems


def test_action_18_the_bases_limits_admit_the_normalised_range_and_no_more(
    robot: RobotManifest,
) -> None:
    """[-1, 1] is 1 m/s, 1 m/s, 1.5 rad/s; twice that is refused."""
    gate = json.loads((ROOT / "robots/panda_mobile/gate.sim.json").read_text())
    limits = [joint["velocity_limit"] for joint in gate["joints"][:3]]
    assert limits == [1.0, 1.0, 1.5]
    slots = slots_of(PI05)
    slots[2]["scale"] = [2.0, 1.0, 1.5]
    problems = "\n".join(admission_problems(with_slots(slots), robot, HAL))
    assert "full-scale output is [-2, 2], the HAL takes [-1, 1]" in problems
