"""``to_confirm`` in robot.yaml: what nobody confirmed is never compiled for a real robot."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import repo_root, robot_dir
from fairlead.robot.manifest import load_robot
from tests.cli.command import fairlead_here as fairlead
from tests.shape.own_robot import NAME, own_robot, with_hardware

SPEED = "joints.panda_joint1.velocity_rad_s"
BLOCK = "safety.hardware.measured.panda_gripper"


def test_hardware_is_not_compiled_nor_started_while_a_number_is_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    with_hardware(folder, {SPEED: "assumed", BLOCK: "not measured"})
    identity = load_robot(NAME).robot_hash
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 0, done.stderr
    refusal = (
        f"robot mine: profile hardware: 2 entries of robot.yaml are still to be confirmed: "
        f"{SPEED}, {BLOCK}; correct each, delete its line in to_confirm, then: fairlead robot "
        "compile mine"
    )
    assert f"{folder / 'gate.hardware.json'} is not made: {refusal}" in done.stderr
    assert (folder / "gate.sim.json").is_file()
    assert not (folder / "gate.hardware.json").exists()
    deployment = tmp_path / "real.yaml"
    text = Path("compose/panda_mujoco.yaml").read_text()
    text = text.replace("robot: panda ", "robot: mine ").replace(
        "profile: sim", "profile: hardware"
    )
    deployment.write_text(text.replace("pacing: lockstep", "pacing: realtime"))
    done = fairlead("up", str(deployment), state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert refusal in done.stderr
    with_hardware(folder, {})
    assert fairlead("robot", "compile", NAME, state=tmp_path).returncode == 0
    assert (folder / "gate.hardware.json").is_file()
    assert load_robot(NAME).robot_hash == identity


@pytest.mark.parametrize(
    ("key", "why", "problem"),
    [
        ("joints.elbow.velocity_rad_s", "assumed", "leads to nothing that robot.yaml gives"),
        ("joints.panda_joint1.velocity_m_s", "assumed", "leads to nothing that robot.yaml gives"),
        ("safety.sim.measured.panda_joint1.", "assumed", "leads to nothing that robot.yaml gives"),
        (SPEED, " ", "expected why, in words, got ' '"),
    ],
)
def test_an_open_entry_names_what_is_there_and_says_why(
    key: str, why: str, problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_hardware(own_robot(tmp_path, monkeypatch), {key: why})
    with pytest.raises(ConfigError) as error:
        load_robot(NAME)
    assert f"to_confirm: {key!r}" in str(error.value)
    assert problem in str(error.value)


SHIPPED = sorted(
    path.parent.name
    for path in (repo_root() / "robots").glob("*/robot.yaml")
    if "hardware" in load_robot(path.parent.name).safety
)
NOBODY_GAVE_IT = re.compile("own choice|chosen|placeholder|not measured|to be measured|assumed")


def blocks(node: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Each block that names its source, by its key in robot.yaml."""
    if isinstance(node, dict):
        if "source" in node:
            yield key, str(node["source"])
        for name, value in node.items():
            yield from blocks(value, f"{key}.{name}".lstrip("."))
    elif isinstance(node, list):
        for value in node:
            if isinstance(value, dict) and "name" in value:
                yield from blocks(value, f"{key}.{value['name']}")


@pytest.mark.parametrize("robot", SHIPPED)
def test_no_number_that_ships_reaches_a_real_robot_unless_somebody_vouches_for_it(
    robot: str,
) -> None:
    document = yaml.safe_load((robot_dir(robot) / "robot.yaml").read_text())
    open_ = load_robot(robot).to_confirm
    document["safety"] = {"hardware": document["safety"]["hardware"]}
    found = [key for key, source in blocks(document) if NOBODY_GAVE_IT.search(source)]
    assert "safety.hardware.workspace" in found
    armed = [key for key in found if not any(f"{key}.".startswith(f"{one}.") for one in open_)]
    assert armed == []


@pytest.mark.parametrize("robot", SHIPPED)
def test_what_ships_is_not_started_on_a_real_robot_before_that(robot: str, tmp_path: Path) -> None:
    deployment = tmp_path / "real.yaml"
    text = (repo_root() / "compose" / "so101.yaml").read_text()
    deployment.write_text(text.replace("robot: so101 ", f"robot: {robot} "))
    done = fairlead("up", str(deployment), state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert f"robot {robot}: profile hardware: " in done.stderr
    assert "safety.hardware.workspace" in done.stderr
    assert not (robot_dir(robot) / "gate.hardware.json").exists()
