"""A hand is an end effector that no single joint opens."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest


@pytest.fixture
def data() -> dict[str, Any]:
    text = Path(robot_dir("dual_panda") / "robot.yaml").read_text(encoding="utf-8")
    loaded: dict[str, Any] = yaml.safe_load(text)
    return loaded


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"gripper_joint": "right_thumb_joint1"},
         "end effector 'right_tool': a hand is actuated and has no gripper_joint"),
        ({"actuated": False},
         "end effector 'right_tool': a hand is actuated and has no gripper_joint"),
    ],
)  # fmt: skip
def test_a_hand_with_a_gripper_joint_or_not_actuated_is_refused(
    data: dict[str, Any], fields: dict[str, Any], problem: str
) -> None:
    assert RobotManifest.model_validate(data).end_effector("right_tool").actuated
    data["end_effectors"][1] |= fields
    with pytest.raises(ValidationError) as caught:
        RobotManifest.model_validate(data)
    assert [error["msg"] for error in caught.value.errors()] == [f"Value error, {problem}"]
