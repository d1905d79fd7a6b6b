"""robot.yaml: what is accepted, and the full text of every refusal but the safety block's."""

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.robot.refused import refusal, top


def test_shipped_robot_has_the_wire_order_of_its_joints_and_parts() -> None:
    robot = load_robot("panda_mobile")
    assert robot.joint_names == (
        "base_x", "base_y", "base_yaw",
        *(f"panda_joint{index}" for index in range(1, 8)),
        "panda_gripper",
    )  # fmt: skip
    assert robot.passive_joint_names == (
        "panda_finger_joint1", "panda_finger_joint2", "torso_height",
    )  # fmt: skip
    assert robot.part_names == ("arm", "gripper", "base", "composite")
    assert robot.n_dof == 11
    assert robot.tick_period_ns == 50_000_000
    assert len(robot.robot_hash) == 32


def test_joints_that_the_simulator_calls_alike_need_no_name_there(data: dict[str, Any]) -> None:
    names = data["simulator"]["joints"]
    del names["torso_height"]
    robot = RobotManifest.model_validate(data)
    assert robot.simulator_joints("torso_height") == ("torso_height",)
    assert robot.simulator_joints("base_x") == ("mobilebase0_joint_mobile_forward",)


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ({"frame_tolerance": {"distance_m": 0.05}}, "less than or equal to 0.01"),
        ({"frames": {"base_link": "mobilebase0_base"}}, "expected body:NAME or site:NAME"),
        ({"joints": {"panda_joint9": ["robot0_joint7"]}}, "unknown panda_joint9 (valid: base_x"),
    ],
)
def test_names_of_the_simulator_that_cannot_be_are_refused(
    data: dict[str, Any], tmp_path: Path, change: dict[str, Any], wanted: str
) -> None:
    data["simulator"] |= change
    assert wanted in refusal(data, tmp_path)


def test_manifest_is_frozen() -> None:
    robot = load_robot("panda_mobile")
    with pytest.raises(ValueError, match="frozen"):
        robot.id = "other"


def test_missing_joint_limit_names_the_joint_and_the_field(
    data: dict[str, Any], tmp_path: Path
) -> None:
    del data["joints"][3]["upper_rad"]
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1' (revolute): missing upper_rad"
    )


def test_limit_in_the_wrong_unit_names_the_joint_and_the_valid_fields(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["joints"][3]["velocity_m_s"] = 1.0
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1' (revolute, bounded by "
        "limits): velocity_m_s does not apply (valid: lower_rad, upper_rad, velocity_rad_s, "
        "acceleration_rad_s2, effort_nm)"
    )


def test_position_limit_of_a_joint_bounded_by_zones_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["joints"][0]["upper_m"] = 5.0
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.0: joint 'base_x' (prismatic, bounded by zones): "
        "upper_m does not apply (valid: velocity_m_s, acceleration_m_s2, effort_n)"
    )


def test_arm_joint_bounded_by_zones_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][3]["bounded_by"] = "zones"
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': only joints of role base "
        "are bounded by zones"
    )


def test_continuous_joint_without_zones_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][2]["bounded_by"] = "limits"
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.2: joint 'base_yaw': a base's continuous joint has no "
        "position limits, so it must be bounded by zones"
    )


@pytest.mark.parametrize("upper", [-2.8973, -3.0])
def test_inverted_or_empty_position_range_names_the_joint(
    data: dict[str, Any], tmp_path: Path, upper: float
) -> None:
    data["joints"][3]["upper_rad"] = upper
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': inverted limits, "
        f"lower -2.8973 is not below upper {upper}"
    )


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_limit_that_forbids_all_motion_names_the_joint(
    data: dict[str, Any], tmp_path: Path, value: float
) -> None:
    data["joints"][3]["effort_nm"] = value
    assert refusal(data, tmp_path) == (
        f"1 problem(s):\n  joints.3: joint 'panda_joint1': expected effort_nm above 0, got {value}"
    )


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_limit_that_is_not_finite_names_the_joint(
    data: dict[str, Any], tmp_path: Path, value: float
) -> None:
    data["joints"][3]["velocity_rad_s"] = value
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': velocity_rad_s is not finite"
    )


def test_limit_without_source_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    del data["joints"][3]["source"]
    assert refusal(data, tmp_path) == "1 problem(s):\n  joints.3.source: is missing"


def test_unknown_key_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][3]["damping"] = 1.0
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3.damping: unknown key (valid: name, role, type, bounded_by, "
        "lower_rad, upper_rad, velocity_rad_s, acceleration_rad_s2, effort_nm, lower_m, upper_m, "
        "velocity_m_s, acceleration_m_s2, effort_n, source)"
    )


def test_joint_that_no_part_commands_is_named(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["joints"].remove("panda_joint7")
    assert refusal(data, tmp_path) == top("joint 'panda_joint7': expected exactly one part, got []")


def test_joint_in_two_parts_is_named(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["joints"].append("panda_joint7")
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["step_limits"] += [1.0]
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["tracking_limits"] += [1.0]
    assert refusal(data, tmp_path) == top(
        "joint 'panda_joint7': expected exactly one part, got ['arm', 'base']"
    )


def test_a_part_that_names_a_joint_twice_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["joints"] = ["base_x", "base_y", "base_yaw", "base_x"]
    assert "part 'base': joint 'base_x' is declared 2 times" in refusal(data, tmp_path)


def test_a_binary_gripper_of_seven_joints_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"].append("gripper_binary")
    data["safety"]["sim"]["parts"]["arm"]["gripper_binary"] = {"source": "test"}
    assert refusal(data, tmp_path).startswith(
        top(
            "part 'arm': gripper_binary: expected exactly one joint, with position limits, got "
            "['panda_joint1', "
        )
    )


def test_part_with_an_unknown_joint_lists_the_joints(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][3]["joints"] = ["torso_height"]
    names = ", ".join(joint["name"] for joint in data["joints"])
    assert refusal(data, tmp_path) == top(
        f"part 'composite': joint 'torso_height' is not a commanded joint (valid: {names})"
    )


def test_duplicate_joint_name_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["passive_joints"].append(copy.deepcopy(data["passive_joints"][2]))
    assert refusal(data, tmp_path) == top("joint 'torso_height' is declared 2 times")


def test_base_joints_that_are_not_the_base_roles_are_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["base_joints"] = ["base_x", "base_y"]
    assert refusal(data, tmp_path) == top(
        "base_joints: expected the joints of role base in order, "
        "['base_x', 'base_y', 'base_yaw'], got ['base_x', 'base_y']"
    )


def test_unknown_mode_lists_the_modes(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"] = ["cartesian_velocity"]
    text = refusal(data, tmp_path)
    assert text.startswith(
        "1 problem(s):\n  parts.0.modes: modes: expected a control mode, "
        "got 'cartesian_velocity' (valid: joint_position, joint_velocity, "
    )


def test_cartesian_mode_without_an_end_effector_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["parts"][0]["end_effector"] = None
    assert refusal(data, tmp_path) == top("part 'arm': cartesian_delta needs an end_effector")


def test_actuated_end_effector_without_a_joint_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    del data["end_effectors"][0]["gripper_joint"]
    assert refusal(data, tmp_path) == top(
        "end effector 'gripper': actuated and gripper_joint go together"
    )


def test_unknown_part_lists_the_parts() -> None:
    with pytest.raises(ConfigError) as error:
        load_robot("panda_mobile").part("torso")
    assert str(error.value) == (
        "robot panda_mobile: expected a part, got 'torso' (valid: arm, gripper, base, composite)"
    )


def test_manifest_in_a_folder_of_another_name_is_refused(
    data: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "robots" / "other"
    folder.mkdir(parents=True)
    (tmp_path / "rskills").mkdir()
    (folder / "robot.yaml").write_text("# a robot\n" + yaml.safe_dump(data, sort_keys=False))
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    with pytest.raises(ConfigError) as error:
        load_robot("other")
    assert str(error.value) == (
        f"{folder / 'robot.yaml'}:2:1: id: expected 'other', the folder's name, got 'panda_mobile'"
    )


def test_missing_description_file_is_refused(
    data: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "robots" / "panda_mobile"
    folder.mkdir(parents=True)
    (tmp_path / "rskills").mkdir()
    (folder / "robot.yaml").write_text(yaml.safe_dump(data))
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    with pytest.raises(ConfigError) as error:
        load_robot("panda_mobile")
    assert str(error.value) == (
        f"robot panda_mobile: no description file {folder / 'panda_mobile.urdf'}"
    )
