"""Which slots may clip their numbers or decide them by a threshold, and what is admitted then."""

from __future__ import annotations

from typing import Any

import pytest

from fairlead.robot.manifest import load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes

MOBILE = load_robot("panda_mobile")
GRIPPER = {"range": [0, 0], "control_mode": "gripper_position", "ee": "gripper"}
BASE = {"range": [0, 2], "control_mode": "joint_velocity",
        "joint_names": ["base_x", "base_y", "base_yaw"], "scale": [1.0, 1.0, 1.5]}  # fmt: skip


def contract(slot: dict[str, Any]) -> ActionContract:
    width = slot["range"][1] + 1
    return ActionContract.model_validate({"dim": width, "slots": [slot]})


@pytest.mark.parametrize(
    ("slot", "text"),
    [
        (GRIPPER | {"clip": [1.0, -1.0]},
         "clip: expected a lower and a higher finite number, got [1.0, -1.0]"),
        (GRIPPER | {"clip": [-1.0, float("inf")]},
         "clip: expected a lower and a higher finite number, got [-1.0, inf]"),
        (GRIPPER | {"clip": [0.0, float("nan")]},
         "clip: expected a lower and a higher finite number, got [0.0, nan]"),
        (GRIPPER | {"clip": [-1.0, 1.0], "threshold": 0.0},
         "clip: not beside threshold, which decides already"),
        (BASE | {"threshold": 0.5}, "threshold: not allowed with joint_velocity"),
        ({"range": [0, 0], "discard": True, "clip": [-1.0, 1.0]},
         "clip: not allowed with discard"),
    ],
)  # fmt: skip
def test_a_clip_or_threshold_that_cannot_be_meant_is_refused(
    slot: dict[str, Any], text: str
) -> None:
    with pytest.raises(ValueError) as caught:
        contract(slot)
    assert text in str(caught.value)


def test_a_route_keeps_what_each_of_its_slots_asks_for() -> None:
    data = {"dim": 3, "slots": [
        BASE | {"range": [0, 0], "joint_names": ["base_x"], "scale": 1.0, "clip": [-0.5, 0.5]},
        BASE | {"range": [1, 1], "joint_names": ["base_y"], "scale": 1.0},
        BASE | {"range": [2, 2], "joint_names": ["base_yaw"], "scale": 1.5, "clip": [-1.0, 1.0]},
    ]}  # fmt: skip
    [route] = resolve_routes(ActionContract.model_validate(data), MOBILE)
    assert [(fit.sources, fit.clip) for fit in route.fits] == [((0,), (-0.5, 0.5)),
                                                               ((2,), (-1.0, 1.0))]  # fmt: skip


@pytest.mark.parametrize(
    ("clip", "fits"), [([-0.5, 0.5], True), ([-1.0, 1.0], False), (None, False)]
)
def test_full_scale_is_what_the_numbers_are_clipped_to(
    clip: list[float] | None, fits: bool
) -> None:
    data = load_skill("oracle-counter-to-cabinet").model_dump(mode="json")
    data["action_contract"]["slots"][2] |= {"scale": [2.0, 2.0, 3.0], "clip": clip}
    found = Admission(SkillManifest.model_validate(data), MOBILE).problems()
    assert (found == []) == fits
