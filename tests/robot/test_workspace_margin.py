"""`workspace.margin_m`: the gate's volumes are the declared ones, less what predictions are off."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead.yaml_file import load_yaml

ROOM = {"lower_m": [-0.2, -0.75, 0.4], "upper_m": [0.95, 0.75, 1.7]}
POST = {"lower_m": [0.6, 0.2, 0.4], "upper_m": [0.7, 0.3, 1.2]}


def robot_with(margin_m: float, room: dict[str, Any] = ROOM) -> dict[str, Any]:
    """The mobile robot's file with a box to stay in and a post to stay out of."""
    text = (robot_dir("panda_mobile") / "robot.yaml").read_text(encoding="utf-8")
    data: dict[str, Any] = json.loads(json.dumps(yaml.safe_load(text)))
    workspace: dict[str, Any] = {
        "volumes": [
            {"name": "room", "kind": "keep_in", **room},
            {"name": "post", "kind": "keep_out", **POST},
        ],
        "margin_m": margin_m,
        "source": "test",
    }
    data["safety"]["sim"]["workspace"] = workspace
    return data


def compiled(data: dict[str, Any]) -> list[dict[str, Any]]:
    text = compile_gate_config(RobotManifest.model_validate(data), "sim")
    volumes: list[dict[str, Any]] = json.loads(text)["workspace"]["volumes"]
    return volumes


def test_a_margin_makes_what_to_stay_in_smaller_and_what_to_stay_out_of_larger() -> None:
    assert compiled(robot_with(0.02)) == [
        {"name": "room", "kind": "keep_in",
         "lower": [-0.18, -0.73, 0.42], "upper": [0.93, 0.73, 1.68]},
        {"name": "post", "kind": "keep_out",
         "lower": [0.58, 0.18, 0.38], "upper": [0.72, 0.32, 1.22]},
    ]  # fmt: skip


def test_a_margin_of_0_leaves_the_declared_edges() -> None:
    room, post = compiled(robot_with(0.0))
    assert (room["lower"], room["upper"]) == (ROOM["lower_m"], ROOM["upper_m"])
    assert (post["lower"], post["upper"]) == (POST["lower_m"], POST["upper_m"])


@pytest.mark.parametrize("margin_m", [0.05, 0.06])
def test_a_margin_that_leaves_no_room_is_refused(tmp_path: Path, margin_m: float) -> None:
    flat = {"lower_m": [-0.2, -0.75, 0.9], "upper_m": [0.95, 0.75, 1.0]}
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(robot_with(0.0499, flat)), encoding="utf-8")
    assert load_yaml(path, RobotManifest)
    path.write_text(yaml.safe_dump(robot_with(margin_m, flat)), encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        load_yaml(path, RobotManifest)
    assert str(error.value).startswith(f"{path}: ")
    assert (
        f"volume 'room': its least side of 0.1 m is not above twice margin_m {margin_m:g}"
        in str(error.value)
    )


@pytest.mark.parametrize("margin_m", [-0.001, 0.2, float("nan")])
def test_a_margin_that_is_none_is_refused(tmp_path: Path, margin_m: float) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(robot_with(margin_m)), encoding="utf-8")
    with pytest.raises(ConfigError, match="workspace.margin_m: "):
        load_yaml(path, RobotManifest)
