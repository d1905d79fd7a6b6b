"""A gate never starts on limits it does not fully understand."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bench.equipment.running_gate import RunningGate
from tests.gate import bad_configurations

pytestmark = pytest.mark.processes

Change = Callable[[dict[str, Any]], object]


def modes(file: dict[str, Any], part: int) -> dict[str, Any]:
    found: dict[str, Any] = file["parts"][part]["modes"]
    return found


BAD: dict[str, tuple[Change, str]] = {
    "unknown key": (
        lambda f: f.update(speed=1),
        "speed: unknown key (valid: base, collision, compiled_from, ",
    ),
    "unknown nested key": (
        lambda f: f["joints"][0].update(velocity=1),
        "joints[0].velocity: unknown key",
    ),
    "missing limit": (
        lambda f: f["joints"][3].pop("velocity_limit"),
        "joints[3].velocity_limit: missing",
    ),
    "missing bounds": (lambda f: f["joints"][3].pop("bounds"), "joints[3].bounds: missing"),
    "both bounds and zones": (
        lambda f: f["joints"][3].update(zones={"frame": "odom"}),
        "joints[3].bounds: unknown key",
    ),
    "no bounds of a joint that has an end": (
        lambda f: f["joints"][3].update(bounds=None),
        "joints[3].bounds: expected an object, got null",
    ),
    "zones of a joint that turns without end": (
        lambda f: f["joints"][3].update(
            kind="continuous", zones=f["joints"][3].pop("bounds") and {"frame": "odom"}
        ),
        'joints[3].zones: expected a joint of base.joints, got "panda_joint1"',
    ),
    "zones in another frame": (
        lambda f: f["joints"][0].update(zones={"frame": "map"}),
        'joints[0].zones.frame: expected "odom", got "map"',
    ),
    "inverted bounds": (
        lambda f: f["joints"][3]["bounds"].update(lower=3.0, upper=-3.0),
        "panda_joint1",
    ),
    "zero limit": (lambda f: f["joints"][3].update(velocity_limit=0.0), "panda_joint1"),
    "negative limit": (lambda f: f["joints"][3].update(jump_limit=-1.0), "panda_joint1"),
    "limit as text": (
        lambda f: f["joints"][3].update(velocity_limit="2"),
        'joints[3].velocity_limit: expected a number, got "2"',
    ),
    "limit null": (
        lambda f: f["joints"][3].update(velocity_limit=None),
        "joints.panda_joint1.velocity_limit: expected a finite number above 0, got nan",
    ),
    "mode without a checker": (
        lambda f: modes(f, 0).update(joint_trajectory={}),
        "parts[0].modes.joint_trajectory: no checker for this mode (valid: joint_position",
    ),
    "no tree": (lambda f: f.pop("kinematics"), "kinematics: missing"),
    "link before its parent": (
        lambda f: f["kinematics"]["links"].reverse(),
        "kinematics.links[0].parent: expected a link that comes before it, got ",
    ),
    "link moved by a joint that is not measured": (
        lambda f: f["kinematics"]["links"][0].update(joint="torso"),
        'kinematics.links[0].joint: expected the name of a measured joint, got "torso"',
    ),
    "fixed link with a joint": (
        lambda f: f["kinematics"]["links"][0].update(kind="fixed"),
        "kinematics.links[0].joint: expected null for a fixed link",
    ),
    "kind of motion that is none": (
        lambda f: f["kinematics"]["links"][0].update(kind="floating"),
        "kinematics.links[0].kind: expected fixed, revolute, continuous or prismatic",
    ),
    "axis of two numbers": (
        lambda f: f["kinematics"]["links"][0].update(axis=[0.0, 1.0]),
        "kinematics.links[0].axis: expected 3 numbers, got [0.0,1.0]",
    ),
    "axis that is no unit": (
        lambda f: f["kinematics"]["links"][0].update(axis=[0.0, 0.0, 1.001]),
        "kinematics.torso.axis: expected a unit length, got 1.001",
    ),
    "rotation as text": (
        lambda f: f["kinematics"]["links"][0].update(rotation_xyzw=["0", 0, 0, 1]),
        'kinematics.links[0].rotation_xyzw[0]: expected a number, got "0"',
    ),
    "unknown key of a link": (
        lambda f: f["kinematics"]["links"][0].update(mass=1.0),
        "kinematics.links[0].mass: unknown key",
    ),
    "link that turns by a joint that slides": (
        lambda f: f["kinematics"]["links"][0].update(joint="panda_joint1"),
        "kinematics.torso.kind: not that of joint panda_joint1",
    ),
    "tool that is no link": (
        lambda f: f["parts"][0].update(tool_frame="hook"),
        "parts[0].tool_frame: expected null or the name of a link",
    ),
    "no tool for a cartesian mode": (
        lambda f: f["parts"][0].update(tool_frame=None),
        "parts.arm.modes.cartesian_delta: the part has no tool_frame",
    ),
    "frame that is no link": (
        lambda f: modes(f, 0)["cartesian_delta"].update(frames=["odom"]),
        "parts.arm.modes.cartesian_delta.frames: odom is no link of the description",
    ),
    "too few steps": (
        lambda f: modes(f, 2)["joint_velocity"].update(step_limit=[1.0]),
        "parts[2].modes.joint_velocity.step_limit: expected 3 numbers, one per joint of the part",
    ),
    "inverted gripper": (
        lambda f: modes(f, 1)["gripper_position"].update(lower=0.1),
        "gripper",
    ),
    "unknown joint": (
        lambda f: f["parts"][0]["joints"].append("panda_joint8"),
        "parts[0].joints[7]: expected the name of one of `joints`",
    ),
    "unknown part": (lambda f: f["joints"][3].update(part="leg"), "no part is called 'leg'"),
    "horizon beyond the gate's": (
        lambda f: f["protocol"].update(horizon_max=65),
        "protocol.horizon_max: expected a whole number from 1 to 64, got 65",
    ),
    "protocol limit missing": (
        lambda f: f["protocol"].pop("state_timeout_ms"),
        "protocol.state_timeout_ms: missing",
    ),
    "another format": (
        lambda f: f.update(format="fairlead-gate-2"),
        'format: expected "fairlead-gate-1", got "fairlead-gate-2"',
    ),
    "hash too short": (
        lambda f: f.update(robot_hash="00"),
        "robot_hash: expected 64 lower-case hexadecimal digits",
    ),
}


def refused(text: str, tmp_path: Path) -> str:
    """Start a gate on this text; it must refuse with status 2 and one line, which is returned."""
    path = tmp_path / "gate.json"
    path.write_text(text)
    gate = RunningGate(path, tmp_path / "state")
    assert gate.wait_exit() == 2
    assert len(gate.lines) == 1
    assert gate.lines[0].startswith(f"ERROR fairlead-safety: configuration {path}: ")
    return gate.lines[0]


@pytest.mark.parametrize("name", BAD)
def test_a_bad_configuration_is_refused_by_name(config: Path, tmp_path: Path, name: str) -> None:
    change, expected = BAD[name]
    file = json.loads(config.read_text())
    change(file)
    assert expected in refused(json.dumps(file), tmp_path)


@pytest.mark.parametrize("name", bad_configurations.BAD)
def test_shape_surroundings_and_tracking_that_are_bad_are_refused_by_name(
    config: Path, tmp_path: Path, name: str
) -> None:
    change, expected = bad_configurations.BAD[name]
    file = json.loads(config.read_text())
    change(file)
    assert expected in refused(json.dumps(file), tmp_path)


TEXTS: dict[str, tuple[str, str, str]] = {
    "NaN": ('"velocity_limit": 2.175', '"velocity_limit": NaN', "joints[3].velocity_limit: "),
    "infinite": ('"velocity_limit": 2.175', '"velocity_limit": 1e999', "joints[3].velocity_limit"),
    "duplicate": (
        '"lockstep_allowed": true',
        '"lockstep_allowed": true, "lockstep_allowed": true',
        "lockstep_allowed: duplicate key",
    ),
    "nested duplicate": (
        '"velocity_limit": 2.175',
        '"velocity_limit": 1.0, "velocity_limit": 2.175',
        "joints[3].velocity_limit: duplicate key",
    ),
    "not JSON": ("{", "", "expected JSON"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text_that_is_not_strict_json_is_refused(config: Path, tmp_path: Path, name: str) -> None:
    old, new, expected = TEXTS[name]
    text = config.read_text()
    assert old in text
    assert expected in refused(text.replace(old, new, 1), tmp_path)


def test_a_missing_file_is_refused_with_the_command_that_makes_it(tmp_path: Path) -> None:
    gate = RunningGate(tmp_path / "none.json", tmp_path / "state")
    assert gate.wait_exit() == 2
    assert gate.lines == [
        f"ERROR fairlead-safety: configuration {tmp_path}/none.json: cannot be read; "
        "make it with: fairlead robot compile"
    ]
