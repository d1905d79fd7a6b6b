"""robot.yaml: what is accepted, and the full text of every refusal."""

import copy
import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.yaml_file import load_yaml


@pytest.fixture(scope="module")
def shipped() -> dict[str, Any]:
    loaded: dict[str, Any] = yaml.safe_load((robot_dir("panda_mobile") / "robot.yaml").read_text())
    return loaded


@pytest.fixture
def data(shipped: dict[str, Any]) -> dict[str, Any]:
    copied: dict[str, Any] = json.loads(json.dumps(shipped))  # YAML's aliases taken apart
    del copied["safety"]["hardware"]  # each complaint once
    return copied


def _refusal(data: dict[str, Any], folder: Path) -> str:
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    with pytest.raises(ConfigError) as error:
        load_yaml(path, RobotManifest)
    return re.sub(rf"{path}(:\d+:\d+)?: ", "", str(error.value))


def _top(text: str) -> str:
    return f"1 problem(s):\n  (top level): {text}"


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


def test_robot_hash_leaves_out_the_safety_block_and_prose(data: dict[str, Any]) -> None:
    before = RobotManifest.model_validate(data).robot_hash
    data["joints"][3]["source"] = "another datasheet"
    data["safety"]["sim"]["parts"]["base"]["body_twist"]["linear_limit_m_s"] = 0.5
    assert RobotManifest.model_validate(data).robot_hash == before


@pytest.mark.parametrize(
    ("block", "index", "field", "value"),
    [
        ("joints", 3, "velocity_rad_s", 1.0),
        ("parts", 0, "hold", "ramp_to_zero"),
        ("end_effectors", 0, "tool_frame", "panda_hand"),
        ("passive_joints", 0, "upper_m", 0.05),
    ],
)
def test_robot_hash_changes_with_limits_hold_laws_and_tools(
    data: dict[str, Any], block: str, index: int, field: str, value: object
) -> None:
    before = RobotManifest.model_validate(data).robot_hash
    assert data[block][index][field] != value
    data[block][index][field] = value
    assert RobotManifest.model_validate(data).robot_hash != before


def test_robot_hash_changes_with_the_order_of_joints(data: dict[str, Any]) -> None:
    before = RobotManifest.model_validate(data).robot_hash
    data["joints"][0], data["joints"][1] = data["joints"][1], data["joints"][0]
    data["base_joints"] = ["base_y", "base_x", "base_yaw"]
    assert RobotManifest.model_validate(data).robot_hash != before


def test_robot_hash_changes_with_the_description_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = load_robot("panda").robot_hash
    shutil.copytree(robot_dir("panda"), tmp_path / "robots" / "panda")
    (tmp_path / "rskills").mkdir()
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    copied = load_robot("panda")
    assert copied.description_path().is_relative_to(tmp_path)
    assert copied.robot_hash == before
    urdf = copied.description_path()
    urdf.write_text(urdf.read_text().replace('xyz="0 0 0.1034"', 'xyz="0 0 0.2068"'))
    assert load_robot("panda").robot_hash != before


def test_joints_that_the_simulator_calls_alike_need_no_name_there(data: dict[str, Any]) -> None:
    names = data["simulator"]["joints"]
    del names["torso_height"]
    robot = RobotManifest.model_validate(data)
    assert robot.simulator_joints("torso_height") == ("torso_height",)
    assert robot.simulator_joints("base_x") == ("mobilebase0_joint_mobile_forward",)


def test_robot_hash_leaves_out_what_only_a_comparison_goes_by(
    shipped: dict[str, Any], data: dict[str, Any]
) -> None:
    data["simulator"]["frame_tolerance"] = {"distance_m": 0.001}
    del data["simulator"]["model"]
    data["no_collision_geometry"]["grip_site"] = "another reason"
    before = RobotManifest.model_validate(shipped).robot_hash
    assert RobotManifest.model_validate(data).robot_hash == before


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
    assert wanted in _refusal(data, tmp_path)


def test_manifest_is_frozen() -> None:
    robot = load_robot("panda_mobile")
    with pytest.raises(ValueError, match="frozen"):
        robot.id = "other"


def test_missing_joint_limit_names_the_joint_and_the_field(
    data: dict[str, Any], tmp_path: Path
) -> None:
    del data["joints"][3]["upper_rad"]
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1' (revolute): missing upper_rad"
    )


def test_limit_in_the_wrong_unit_names_the_joint_and_the_valid_fields(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["joints"][3]["velocity_m_s"] = 1.0
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1' (revolute, bounded by "
        "limits): velocity_m_s does not apply (valid: lower_rad, upper_rad, velocity_rad_s, "
        "acceleration_rad_s2, effort_nm)"
    )


def test_position_limit_of_a_joint_bounded_by_zones_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["joints"][0]["upper_m"] = 5.0
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.0: joint 'base_x' (prismatic, bounded by zones): "
        "upper_m does not apply (valid: velocity_m_s, acceleration_m_s2, effort_n)"
    )


def test_arm_joint_bounded_by_zones_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][3]["bounded_by"] = "zones"
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': only joints of role base "
        "are bounded by zones"
    )


def test_continuous_joint_without_zones_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][2]["bounded_by"] = "limits"
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.2: joint 'base_yaw': a base's continuous joint has no "
        "position limits, so it must be bounded by zones"
    )


@pytest.mark.parametrize("upper", [-2.8973, -3.0])
def test_inverted_or_empty_position_range_names_the_joint(
    data: dict[str, Any], tmp_path: Path, upper: float
) -> None:
    data["joints"][3]["upper_rad"] = upper
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': inverted limits, "
        f"lower -2.8973 is not below upper {upper}"
    )


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_limit_that_forbids_all_motion_names_the_joint(
    data: dict[str, Any], tmp_path: Path, value: float
) -> None:
    data["joints"][3]["effort_nm"] = value
    assert _refusal(data, tmp_path) == (
        f"1 problem(s):\n  joints.3: joint 'panda_joint1': expected effort_nm above 0, got {value}"
    )


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_limit_that_is_not_finite_names_the_joint(
    data: dict[str, Any], tmp_path: Path, value: float
) -> None:
    data["joints"][3]["velocity_rad_s"] = value
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3: joint 'panda_joint1': velocity_rad_s is not finite"
    )


def test_limit_without_source_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    del data["joints"][3]["source"]
    assert _refusal(data, tmp_path) == "1 problem(s):\n  joints.3.source: is missing"


def test_unknown_key_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["joints"][3]["damping"] = 1.0
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  joints.3.damping: unknown key (valid: name, role, type, bounded_by, "
        "lower_rad, upper_rad, velocity_rad_s, acceleration_rad_s2, effort_nm, lower_m, upper_m, "
        "velocity_m_s, acceleration_m_s2, effort_n, source)"
    )


def test_joint_that_no_part_commands_is_named(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["joints"].remove("panda_joint7")
    assert _refusal(data, tmp_path) == _top(
        "joint 'panda_joint7': expected exactly one part, got []"
    )


def test_joint_in_two_parts_is_named(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["joints"].append("panda_joint7")
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["step_limits"] += [1.0]
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["tracking_limits"] += [1.0]
    assert _refusal(data, tmp_path) == _top(
        "joint 'panda_joint7': expected exactly one part, got ['arm', 'base']"
    )


def test_a_part_that_names_a_joint_twice_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["joints"] = ["base_x", "base_y", "base_yaw", "base_x"]
    assert "(top level): part 'base': joint 'base_x' is declared 2 times" in _refusal(
        data, tmp_path
    )


def test_a_binary_gripper_of_seven_joints_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"].append("gripper_binary")
    data["safety"]["sim"]["parts"]["arm"]["gripper_binary"] = {"source": "test"}
    assert _refusal(data, tmp_path).startswith(
        _top(
            "part 'arm': gripper_binary: expected exactly one joint, with position limits, got "
            "['panda_joint1', "
        )
    )


def test_part_with_an_unknown_joint_lists_the_joints(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][3]["joints"] = ["torso_height"]
    names = ", ".join(joint["name"] for joint in data["joints"])
    assert _refusal(data, tmp_path) == _top(
        f"part 'composite': joint 'torso_height' is not a commanded joint (valid: {names})"
    )


def test_duplicate_joint_name_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["passive_joints"].append(copy.deepcopy(data["passive_joints"][2]))
    assert _refusal(data, tmp_path) == _top("joint 'torso_height' is declared 2 times")


def test_base_joints_that_are_not_the_base_roles_are_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["base_joints"] = ["base_x", "base_y"]
    assert _refusal(data, tmp_path) == _top(
        "base_joints: expected the joints of role base in order, "
        "['base_x', 'base_y', 'base_yaw'], got ['base_x', 'base_y']"
    )


def test_unknown_mode_lists_the_modes(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"] = ["cartesian_velocity"]
    text = _refusal(data, tmp_path)
    assert text.startswith(
        "1 problem(s):\n  parts.0.modes: modes: expected a control mode, "
        "got 'cartesian_velocity' (valid: joint_position, joint_velocity, "
    )


def test_mode_the_gate_cannot_check_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"].append("joint_trajectory")
    assert _refusal(data, tmp_path) == _top(
        "safety.sim: part 'arm': the gate has no checker for joint_trajectory"
    )


def test_mode_without_limits_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["parts"]["base"]["body_twist"]
    assert _refusal(data, tmp_path) == _top("safety.sim: part 'base' modes: missing body_twist")


def test_limits_for_a_mode_the_part_lacks_are_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["modes"] = ["joint_velocity"]
    assert _refusal(data, tmp_path) == _top(
        "safety.sim: part 'base' modes: unknown body_twist (valid: joint_velocity)"
    )


def test_measured_limits_must_cover_every_joint(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["measured"]["torso_height"]
    assert _refusal(data, tmp_path) == _top("safety.sim: measured: missing torso_height")


def test_tolerance_goes_with_position_limits(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["measured"]["panda_joint1"]["tolerance"]
    data["safety"]["sim"]["measured"]["base_yaw"]["tolerance"] = 0.1
    assert _refusal(data, tmp_path) == (
        "2 problem(s):\n  (top level): safety.sim: measured: joint 'base_yaw': tolerance is given "
        "for a joint without position limits\n"
        "  (top level): safety.sim: measured: joint 'panda_joint1': tolerance is missing"
    )


def test_step_limits_of_the_wrong_width_are_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["step_limits"] = [2.0, 2.0]
    assert _refusal(data, tmp_path) == _top(
        "safety.sim: part 'base': step_limits: expected one per joint, 3, got 2"
    )


def test_a_deadline_that_states_grow_too_old_before_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["safety"]["sim"]["protocol"] |= {"step_deadline_us": 250_000, "state_timeout_ms": 250}
    assert _refusal(data, tmp_path) == _top(
        "safety.sim: protocol: step_deadline_us: expected less than state_timeout_ms, 250000 us,"
        " got 250000"
    )


def test_inverted_gripper_range_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["safety"]["sim"]["parts"]["gripper"]["gripper_position"]["upper_m"] = -0.01
    assert _refusal(data, tmp_path) == (
        "1 problem(s):\n  safety.sim.parts.gripper.gripper_position: "
        "gripper_position: inverted limits, lower_m 0.0 is not below upper_m -0.01"
    )


def test_cartesian_mode_without_an_end_effector_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["parts"][0]["end_effector"] = None
    assert _refusal(data, tmp_path) == _top("part 'arm': cartesian_delta needs an end_effector")


def test_actuated_end_effector_without_a_joint_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    del data["end_effectors"][0]["gripper_joint"]
    assert _refusal(data, tmp_path) == _top(
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
    (folder / "robot.yaml").write_text(yaml.safe_dump(data))
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    with pytest.raises(ConfigError) as error:
        load_robot("other")
    assert str(error.value) == (
        f"{folder / 'robot.yaml'}: expected id 'other' (its folder), got 'panda_mobile'"
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
