"""What counts for who a robot is, and what does not."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot


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


def test_robot_hash_leaves_out_what_only_a_comparison_goes_by(
    shipped: dict[str, Any], data: dict[str, Any]
) -> None:
    data["simulator"]["frame_tolerance"] = {"distance_m": 0.001}
    del data["simulator"]["model"]
    data["no_collision_geometry"]["grip_site"] = "another reason"
    before = RobotManifest.model_validate(shipped).robot_hash
    assert RobotManifest.model_validate(data).robot_hash == before
