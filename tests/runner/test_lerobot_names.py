"""A LeRobot dataset's names and units against a skill of joints."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fairlead.errors import ConfigError
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policies.lerobot.checkpoint import check_dataset, check_told

ARM = ["shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll"]
PARTS = {"scale": [0.0192] * 5, "offset": [0.0, 0.1, -0.05, 0.0, 0.0]}  # rad per hundredth
JAW = {"scale": 0.0192, "offset": -0.17}


def joints_dataset(folder: Path, rate_hz: float, *names: str) -> Path:
    features = {key: {"names": {"motors": list(names)}} for key in ("observation.state", "action")}
    (folder / "meta").mkdir(parents=True, exist_ok=True)
    told = {"fps": rate_hz, "features": features}
    (folder / "meta" / "info.json").write_text(json.dumps(told))
    return folder


def so101(change: Callable[[dict[str, Any]], None]) -> SkillManifest:
    document = load_skill("so101-reach").model_dump(mode="json", exclude_defaults=True)
    change(document)
    return SkillManifest.model_validate(document)


def in_hundredths(document: dict[str, Any]) -> None:
    """As an SO-101 of LeRobot's says it: the arm -100 to 100, the jaw 0 to 100."""
    one = {"quantity": "position", "unit": "rad"}
    document["state_contract"]["joints"] = [
        one | {"names": ARM} | PARTS, one | {"names": ["gripper"]} | JAW
    ]  # fmt: skip
    for slot, scaled in zip(document["action_contract"]["slots"], (PARTS, JAW), strict=True):
        slot |= scaled


def dataset_refusal(skill: SkillManifest, folder: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        check_dataset(skill, folder)
    return [line.strip() for line in str(caught.value).splitlines()[1:]]


def test_numbers_of_lerobot_s_robots_need_a_scale(tmp_path: Path) -> None:
    skill, scaled = load_skill("so101-reach"), so101(in_hundredths)
    data = joints_dataset(tmp_path, skill.rate_hz, *(f"{name}.pos" for name in [*ARM, "gripper"]))
    check_dataset(scaled, data)
    reason = (
        "numbers of LeRobot's robots are -100 to 100 or degrees, a gripper's 0 to 100, from the "
        "zeros of its own calibration, got neither"
    )
    names = ", ".join(f"{name}.pos" for name in [*ARM, "gripper"])
    assert dataset_refusal(skill, data) == [
        f"{key}: {names}: expected their scale or offset in the skill's {where}: {reason}"
        for key, where in (("observation.state", "state_contract.joints"), ("action", "slots"))
    ]

    def but_the_jaw(document: dict[str, Any]) -> None:
        in_hundredths(document)
        del document["action_contract"]["slots"][1]["scale"]
        del document["action_contract"]["slots"][1]["offset"]

    assert dataset_refusal(so101(but_the_jaw), data) == [
        f"action: gripper.pos: expected their scale or offset in the skill's slots: {reason}"
    ]
    check_dataset(skill, joints_dataset(tmp_path, skill.rate_hz, *ARM, "gripper"))


def test_a_checkpoint_whose_actions_are_lerobot_s_robots_needs_a_scale(tmp_path: Path) -> None:
    names = [f"{name}.pos" for name in [*ARM, "gripper"]]
    told = {"type": "pi0", "inputs": {"observation.state": [6]}, "outputs": {"action": [6]},
            "deltas": None, "action_names": names, "without_statistics": []}  # fmt: skip
    check_told(so101(in_hundredths), tmp_path, told)
    with pytest.raises(ConfigError, match="action: shoulder_pan.pos, .*: expected their scale or"):
        check_told(load_skill("so101-reach"), tmp_path, told)


def test_the_order_of_a_dataset_is_the_vector_s_not_that_of_the_slots_in_the_file(
    tmp_path: Path,
) -> None:
    def jaw_first_in_the_file(document: dict[str, Any]) -> None:
        document["action_contract"]["slots"].reverse()

    skill = so101(jaw_first_in_the_file)
    check_dataset(skill, joints_dataset(tmp_path, skill.rate_hz, *ARM, "gripper"))
    told = joints_dataset(tmp_path, skill.rate_hz, "gripper", *ARM)
    [_, action] = dataset_refusal(skill, told)
    assert action.endswith(f"or {', '.join([*ARM, 'gripper'])}, got gripper, {', '.join(ARM)}")
