"""What no gate file is compiled from: each fault of robot.yaml or capsules.yaml by its name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.yaml_file import load_yaml
from tests.gate.file_edits import Change, again, put
from tests.robot.bad_manifests import BAD


def good_file(name: str) -> dict[str, Any]:
    text = (robot_dir("panda_mobile") / name).read_text(encoding="utf-8")
    apart: dict[str, Any] = json.loads(json.dumps(yaml.safe_load(text)))
    return apart


def write(path: Path, data: dict[str, Any]) -> Path:
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


@pytest.mark.parametrize("name", BAD)
def test_a_bad_robot_yaml_is_refused_by_name(tmp_path: Path, name: str) -> None:
    change, expected = BAD[name]
    data = good_file("robot.yaml")
    change(data)
    path = write(tmp_path / "robot.yaml", data)
    with pytest.raises(ConfigError) as error:
        load_yaml(path, RobotManifest)
    assert str(error.value).startswith(f"{path}: ")
    assert expected in str(error.value)


def test_what_is_wrong_inside_a_list_does_not_make_the_list_too_short(tmp_path: Path) -> None:
    data = good_file("robot.yaml")
    data["parts"] = [data["parts"][0] | {"modes": ["cartesian_dleta"]}]
    with pytest.raises(ConfigError) as error:
        load_yaml(write(tmp_path / "robot.yaml", data), RobotManifest)
    assert "parts.0.modes" in str(error.value)
    assert "at least 1 item" not in str(error.value)
    data["parts"] = []
    with pytest.raises(ConfigError, match="parts: expected at least 1 item, got 0"):
        load_yaml(write(tmp_path / "robot.yaml", data), RobotManifest)


PLAIN: dict[str, Any] = {
    "source": "by hand",
    "capsules": [
        {"link": link, "a_m": [0, 0, 0], "b_m": [0, 0, 0.1], "radius_m": 0.05}
        for link in ("torso", "panda_link3", "panda_hand")
    ],
    "checked_pairs": [[0, 2]],
    "never_checked": [
        {"links": ["torso", "panda_link3"], "why": "test"},
        {"links": ["panda_link3", "panda_hand"], "why": "test"},
    ],
}
BAD_SHAPES: dict[str, tuple[Change, str]] = {
    "radius 0": (put("capsules.0.radius_m", 0), "capsules.0.radius_m: "),
    "end of two numbers": (put("capsules.1.a_m", [0, 0]), "capsules.1.a_m"),
    "pair backwards": (
        put("checked_pairs", [[2, 0]]),
        "checked_pairs: expected two capsules in ascending order below 3, got [2, 0]",
    ),
    "pair twice": (again("checked_pairs"), "checked_pairs: [0, 2] is there twice"),
    "pair of one link": (
        put("capsules.2.link", "torso"),
        "checked_pairs: [0, 2] are both on torso",
    ),
    "pair left open": (
        put("never_checked", PLAIN["never_checked"][:1]),
        "expected panda_link3 and panda_hand in checked_pairs or once in never_checked, got them "
        "in neither",
    ),
    "pair checked and not": (
        put("checked_pairs", [[0, 1], [0, 2]]),
        "expected torso and panda_link3 in checked_pairs or once in never_checked, got them more "
        "than once",
    ),
    "no reason": (put("never_checked.0.why", ""), "never_checked.0.why: "),
    "reason for a link without capsule": (
        put("never_checked.0.links", ["torso", "panda_link9"]),
        "never_checked: 'panda_link9' has no capsule (valid: torso, panda_link3, panda_hand)",
    ),
}


@pytest.mark.parametrize("name", BAD_SHAPES)
def test_a_bad_capsules_yaml_is_refused_by_name(tmp_path: Path, name: str) -> None:
    change, expected = BAD_SHAPES[name]
    data = json.loads(json.dumps(PLAIN))
    assert load_yaml(write(tmp_path / "good.yaml", data), CapsuleFile)
    change(data)
    path = write(tmp_path / "capsules.yaml", data)
    with pytest.raises(ConfigError) as error:
        load_yaml(path, CapsuleFile)
    assert str(error.value).startswith(f"{path}: ")
    assert expected in str(error.value)


def test_capsules_that_are_not_there_are_refused_with_the_command_that_makes_them() -> None:
    robot = load_robot("panda_mobile").model_copy(update={"capsules": "none.yaml"})
    with pytest.raises(ConfigError) as error:
        compile_gate_config(robot, "sim")
    assert str(error.value) == (
        f"robot panda_mobile: no file {robot_dir('panda_mobile')}/none.yaml; make it with: "
        "fairlead robot capsules panda_mobile"
    )


def test_a_source_longer_than_the_gate_keeps_is_refused() -> None:
    data = good_file("robot.yaml")
    data["safety"]["sim"]["workspace"]["source"] = "é" * 128
    assert compile_gate_config(RobotManifest.model_validate(data), "sim")
    data["safety"]["sim"]["workspace"]["source"] += "!"
    with pytest.raises(ConfigError) as error:
        compile_gate_config(RobotManifest.model_validate(data), "sim")
    assert str(error.value).startswith(
        "robot panda_mobile: gate file: workspace.source: expected at most 256 bytes, got 257: "
    )
