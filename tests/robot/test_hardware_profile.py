"""The profile for a real panda_mobile: nowhere looser than the simulator's, and sourced."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.yaml_file import load_yaml
from tests.gate.file_edits import put

LOOSER_WHEN_SMALLER = {
    "singularity_limit",
    "clearance",
    "reaction_s",
    "encoder_step",
    "stop_lag",
    "tool_drift",
    "clearance_drift",
}
IDENTITY = {"kinematics", "robot_hash", "period_ns", "profile", "axis", "capsules", "pairs"}
NOT_COMPARABLE = {"gain", "footprint", "yaw_axis", "zones", "volumes", "stop_window_s"}
"""An unmeasured gain is wider; places are compared by hand below."""


def numbers(node: Any, path: str = "") -> dict[str, float]:
    """Every number of a compiled file by its path, but those that are no limits."""
    if isinstance(node, dict):
        keys = [key for key in node if key not in IDENTITY | NOT_COMPARABLE]
        return {k: v for key in keys for k, v in numbers(node[key], f"{path}.{key}").items()}
    if isinstance(node, list):
        parts = [numbers(value, f"{path}.{index}") for index, value in enumerate(node)]
        return {key: value for part in parts for key, value in part.items()}
    known = isinstance(node, int | float) and not isinstance(node, bool)
    return {path: float(node)} if known else {}


def compiled(profile: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(compile_gate_config(load_robot("panda_mobile"), profile))
    return data


def test_no_number_is_looser_than_the_simulators() -> None:
    sim, hardware = numbers(compiled("sim")), numbers(compiled("hardware"))
    assert len(hardware) > 150
    skipped = (".lower", ".upper", ".free_axes.")
    looser = []
    for path, value in hardware.items():
        name = path.rsplit(".", 1)[-1]
        if any(part in f"{path}." for part in skipped):
            continue
        if (value < sim[path]) if name in LOOSER_WHEN_SMALLER else (value > sim[path]):
            looser.append(path)
    assert looser == []


def test_it_forbids_what_only_a_simulator_can_take() -> None:
    file = compiled("hardware")
    assert file["lockstep_allowed"] is False
    parts = {part["name"]: part for part in file["parts"]}
    assert parts["composite"]["modes"]["composite_mode"]["switching"] == "at_standstill"
    assert parts["base"]["transitions"] == []
    assert parts["base"]["modes"]["body_twist"]["free_axes"] == [0, 5]  # never sideways
    assert parts["gripper"]["modes"]["gripper_position"]["slip_limit"] == 0.005


def test_its_arm_stays_within_the_makers_limits() -> None:
    """Franka Control Interface: 1.7 m/s, 2.5 rad/s, 13 m/s2, 25 rad/s2, 87 and 12 N m."""
    file = compiled("hardware")
    delta = file["parts"][0]["modes"]["cartesian_delta"]
    period_s = 0.05
    assert delta["linear_limit"] / period_s == pytest.approx(0.25)  # ISO 10218-1, reduced speed
    assert delta["angular_limit"] / period_s <= 2.5
    assert delta["linear_step_limit"] / period_s**2 <= 13.0
    assert delta["angular_step_limit"] / period_s**2 <= 25.0
    joints = {joint["name"]: joint for joint in file["joints"]}
    fci = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]
    for index, most in enumerate(fci, start=1):
        joint = joints[f"panda_joint{index}"]
        assert joint["acceleration_limit"] == most / 2
        assert joint["contact_limit"] <= (87.0 if index <= 4 else 12.0)


def test_its_places_are_placeholders_that_hardly_let_it_move() -> None:
    file = compiled("hardware")
    assert [zone["name"] for zone in file["base"]["zones"]] == ["replace_this_zone"]
    assert [volume["name"] for volume in file["workspace"]["volumes"]] == ["replace_this_reach"]
    xs, ys = zip(*file["base"]["zones"][0]["corners"], strict=True)
    assert (min(xs), max(xs), min(ys), max(ys)) == (-1.0, 1.0, -1.0, 1.0)
    for block in (file["base"], file["workspace"]):
        assert block["source"].startswith("placeholder, set ")


def test_a_profile_may_only_tighten_a_joint(tmp_path: Path) -> None:
    text = (robot_dir("panda_mobile") / "robot.yaml").read_text(encoding="utf-8")
    data = json.loads(json.dumps(yaml.safe_load(text)))
    put("safety.hardware.tighter_joints.base_x.velocity_per_s", 1.01)(data)
    put("safety.hardware.tighter_joints.torso_height", {"source": "test"})(data)
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_yaml(path, RobotManifest)
    assert (
        "safety.hardware: tighter_joints: joint 'base_x': expected velocity_per_s of at most its "
        "own, 1.0, got 1.01"
    ) in str(error.value)
    assert "tighter_joints: 'torso_height' is no commanded joint (valid: base_x, " in str(
        error.value
    )


def test_a_tighter_joint_changes_the_profile_and_not_the_robot() -> None:
    sim, hardware = compiled("sim"), compiled("hardware")
    assert (
        hardware["robot_hash"] == sim["robot_hash"] == load_robot("panda_mobile").robot_hash.hex()
    )
    assert [file["joints"][0]["velocity_limit"] for file in (sim, hardware)] == [1.0, 0.3]
