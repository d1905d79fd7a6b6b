"""Skill manifests: the shipped one loads, and what does not fit is named."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.paths import rskill_dir
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.yaml_file import load_yaml

ORACLE = "oracle-counter-to-cabinet"


def changed(tmp_path: Path, **changes: Any) -> Path:
    data = yaml.safe_load((rskill_dir(ORACLE) / "rskill.yaml").read_text())
    path = tmp_path / "rskill.yaml"
    path.write_text(yaml.safe_dump(data | changes))
    return path


def test_the_shipped_skill_emits_the_checkpoint_format() -> None:
    skill = load_skill(ORACLE)
    assert [(s.first, s.last, s.control_mode) for s in skill.action_contract.slots] == [
        (0, 5, "cartesian_delta"),
        (6, 6, "gripper_position"),
        (7, 9, "joint_velocity"),
        (10, 10, None),
        (11, 11, "composite_mode"),
    ]
    assert skill.state_contract.layout == "mobile_pick_30d"


def test_the_hash_depends_on_content_and_not_on_how_the_file_is_written(tmp_path: Path) -> None:
    same = load_yaml(changed(tmp_path), SkillManifest)
    other = load_yaml(changed(tmp_path, prompt="something else"), SkillManifest)
    assert same.skill_hash == load_skill(ORACLE).skill_hash
    assert other.skill_hash != same.skill_hash
    assert len(same.skill_hash) == 32


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (
            {"execute_steps": 9},
            "execute_steps: expected at most the horizon, 8, got 9",
        ),
        ({"horizon": 0}, "horizon: Input should be greater than or equal to 1, got 0"),
        ({"version": "1"}, "version: String should match pattern '^\\d+\\.\\d+\\.\\d+$', got '1'"),
        (
            {"id": "Big Oracle"},
            "id: skill id: expected 1 to 64 of a-z 0-9 _ . - starting "
            "with a letter or "
            "digit, got 'Big Oracle'",
        ),
        (
            {"policy": {"backend": ""}},
            "policy.backend: String should have at least 1 character, got ''",
        ),
        (
            {"torso": True},
            "torso: unknown key (valid: id, version, licence, model_family, policy, embodiments, "
            "prompt, images, state_contract, action_contract, rate_hz, between, horizon, "
            "execute_steps, seam, age_max_ticks, inference_timeout_s, decided_by, limits)",
        ),
        (
            {
                "limits": [
                    {"part": "arm", "control_mode": "warp", "name": "linear_limit", "value": 1}
                ]
            },
            "limits.0.control_mode: expected a mode, got 'warp' "
            "(valid: cartesian_pose, "
            "cartesian_delta, cartesian_twist, joint_position, joint_velocity, "
            "dex_hand_joint, gripper_binary, gripper_position, body_twist, composite_mode)",
        ),
        (
            {
                "limits": [
                    {"part": "arm", "control_mode": "body_twist", "name": "x", "value": 1e999}
                ]
            },
            "limits.0.value: Input should be a finite number, got inf",
        ),
        ({"rate_hz": float("inf")}, "rate_hz: Input should be a finite number, got inf"),
    ],
)
def test_a_field_that_does_not_fit_is_named(
    tmp_path: Path, changes: dict[str, Any], text: str
) -> None:
    path = changed(tmp_path, **changes)
    with pytest.raises(ConfigError) as caught:
        load_yaml(path, SkillManifest)
    heading, problem = str(caught.value).splitlines()
    assert heading == f"{path}: 1 problem(s):"
    assert re.sub(rf"^  {path}:\d+:\d+: ", "", problem) == text


@pytest.mark.parametrize(
    ("scale", "said"),
    [
        (True, "expected a number, got True"),
        ("0.5", "expected a number, or a list of them, got '0.5'"),
        ({"x": 1}, "expected a number, or a list of them, got {'x': 1}"),
        ([1.0, True, 1.0, 1.0, 1.0, 1.0], "expected a number, got True"),
    ],
)
def test_a_scale_is_numbers_and_nothing_that_could_be_one(
    tmp_path: Path, scale: object, said: str
) -> None:
    slots = yaml.safe_load(changed(tmp_path).read_text())["action_contract"]
    slots["slots"][0]["scale"] = scale
    with pytest.raises(ConfigError, match=re.escape(said)):
        load_yaml(changed(tmp_path, action_contract=slots), SkillManifest)


@pytest.mark.parametrize("rate_hz", [1e-300, 1e-6, 20.0000001, 1e300])
def test_a_rate_far_from_the_robots_is_no_fraction_of_it(tmp_path: Path, rate_hz: float) -> None:
    skill = load_yaml(changed(tmp_path, rate_hz=rate_hz), SkillManifest)
    assert skill.control_periods(50_000_000) in (None, 1, 20_000_000)


def test_a_folder_named_unlike_its_skill_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robots").mkdir()
    folder = tmp_path / "rskills" / "other"
    folder.mkdir(parents=True)
    changed(folder)
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    with pytest.raises(ConfigError) as caught:
        load_skill("other")
    assert str(caught.value) == (
        f"{folder / 'rskill.yaml'}:49:1: id: expected 'other', the folder's name, got '{ORACLE}'"
    )
