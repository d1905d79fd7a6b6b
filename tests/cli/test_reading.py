"""Commands that read: tables for people, one JSON document for programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from tests.cli.command import fairlead_here as fairlead

SKILL = "oracle-counter-to-cabinet"


def document(*arguments: str, state: Path, code: int = 0) -> Any:
    done = fairlead(*arguments, "--json", state=state)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


def test_skill_ls_lists_every_skill_with_its_admission(tmp_path: Path) -> None:
    rows = {row["skill"]: row for row in document("skill", "ls", state=tmp_path)}
    assert rows[SKILL] == {"skill": SKILL, "admitted": True, "reasons": []}


def test_robot_ls_lists_every_robot_with_its_parts_and_modes(tmp_path: Path) -> None:
    rows = {row["robot"]: row for row in document("robot", "ls", state=tmp_path)}
    parts = {part.name: list(part.modes) for part in load_robot("panda").parts}
    assert rows["panda"] == {"robot": "panda", "hz": 20.0, "joints": 8, "parts": parts}
    table = fairlead("robot", "ls", state=tmp_path).stdout
    assert "dual_panda" in table and "right_hand" in table


def test_skill_check_passes_the_shipped_skill(tmp_path: Path) -> None:
    report = document("skill", "check", SKILL, state=tmp_path)
    assert report == {
        "skill": SKILL,
        "robot": "panda_mobile",
        "admitted": True,
        "reasons": [],
        "warnings": [],
    }


def test_skill_show_prints_what_the_manifest_says(tmp_path: Path) -> None:
    shown = document("skill", "show", SKILL, state=tmp_path)
    manifest = load_skill(SKILL)
    assert shown.pop("skill_hash") == manifest.skill_hash.hex()
    assert shown == manifest.model_dump(mode="json")


def test_robot_show_prints_what_the_gate_will_enforce(tmp_path: Path) -> None:
    shown = document("robot", "show", "panda_mobile", state=tmp_path)
    assert shown == json.loads(compile_gate_config(load_robot("panda_mobile"), "sim"))
    table = fairlead("robot", "show", "panda_mobile", state=tmp_path).stdout
    assert "None" not in table
    assert "linear_limit 0.0867" in table and "panda_joint7" in table


@pytest.mark.simulator
def test_robot_compile_check_finds_the_committed_file_current(tmp_path: Path) -> None:
    done = fairlead("robot", "compile", "panda_mobile", "--check", state=tmp_path)
    assert done.returncode == 0 and "gate.sim.json is current" in done.stdout


def test_layout_ls_lists_the_layouts_with_an_assembler(tmp_path: Path) -> None:
    names = [row["layout"] for row in document("layout", "ls", state=tmp_path)]
    assert {"human300_16d", "mobile_pick_30d"} <= set(names)


def test_ps_with_nothing_running_is_an_empty_list(tmp_path: Path) -> None:
    assert document("ps", state=tmp_path) == []


@pytest.mark.simulator
def test_layout_verify_agrees_with_the_simulator(tmp_path: Path) -> None:
    report = document("layout", "verify", SKILL, "--ticks", "20", state=tmp_path)
    assert report["ok"] and report["ticks"] == 20
    assert all(field["worst"] <= field["allowed"] for field in report["fields"])
