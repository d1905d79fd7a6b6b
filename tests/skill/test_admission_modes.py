"""Full scale of every mode against what the HAL takes: at its range admitted, above it refused."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from fairlead.hal import describe_part
from fairlead.messages import HalStatus, floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.candidate import dispatch
from fairlead_skill_runner.control_rows import control_rows

ROBOT = load_robot("dual_panda")
SKILL = load_skill("dual-panda-lift")
HAL = HalStatus(
    session=1, robot=ROBOT.id, robot_hash=ROBOT.robot_hash, pacing="lockstep",
    period_ns=ROBOT.tick_period_ns, tick=1, episode_tick=1, state="ready", detail="",
    joints=ROBOT.joint_names, passive_joints=ROBOT.passive_joint_names,
    parts=tuple(describe_part(ROBOT, part, "sim") for part in ROBOT.parts),
    simulator_order=(), cameras=(), has_task=False, overruns=0,
)  # fmt: skip
LEFT = {"ee": "left_tool", "frame": "base_link"}


def changed(width: int, slot: dict[str, Any], rate_hz: float = SKILL.rate_hz) -> SkillManifest:
    data = SKILL.model_dump(mode="json") | {"rate_hz": rate_hz}
    data["action_contract"] = {"dim": width, "slots": [{"range": [0, width - 1], **slot}]}
    return SkillManifest.model_validate(data)


def problems(
    width: int,
    slot: dict[str, Any],
    hal: HalStatus | None = HAL,
    rate_hz: float = SKILL.rate_hz,
) -> list[str]:
    return admission_problems(changed(width, slot, rate_hz), ROBOT, hal)


@pytest.mark.parametrize(
    ("mode", "width", "fields", "part", "largest"),
    [
        ("joint_velocity", 1, {"joint_names": ["right_joint6"]}, "right_arm", 2.61),
        ("cartesian_delta", 6, LEFT, "left_arm", 0.125 / np.sqrt(3.0)),
        ("cartesian_twist", 6, LEFT, "left_arm", 2.5 / np.sqrt(3.0)),
    ],
)
def test_a_scale_is_admitted_up_to_the_range_of_its_mode(
    mode: str, width: int, fields: dict[str, Any], part: str, largest: float
) -> None:
    scale = [1e-3] * (width - 1) + [largest]
    assert problems(width, {"control_mode": mode, **fields, "scale": scale}) == []
    scale[-1] *= 1.01
    index = ROBOT.part(part).joints.index(fields["joint_names"][0]) if width == 1 else 5
    (found,) = problems(width, {"control_mode": mode, **fields, "scale": scale})
    assert found.startswith(
        f"part {part} {mode} value {index}: full-scale output is [-{scale[-1]:g}, {scale[-1]:g}], "
        f"the HAL takes [-{largest:g}, {largest:g}]"
    )


DELTA = {"control_mode": "cartesian_delta", **LEFT}
HALF_RATE_HZ = 0.5e9 / ROBOT.tick_period_ns


@pytest.mark.parametrize(("hal", "who"), [(HAL, "HAL"), (None, "robot")])
def test_a_slower_policys_delta_may_be_as_large_as_its_periods_add_up_to(
    hal: HalStatus | None, who: str
) -> None:
    fits = DELTA | {"scale": [1e-3] * 5 + [0.144337]}  # twice a norm of 0.125 rad over sqrt(3)
    assert problems(6, fits, hal, HALF_RATE_HZ) == []
    assert len(problems(6, fits, hal)) == 1  # at the control rate
    (found,) = problems(6, fits | {"scale": [1e-3] * 5 + [0.145]}, hal, HALF_RATE_HZ)
    assert found == (
        f"part left_arm cartesian_delta value 5: full-scale output is [-0.145, 0.145], the {who} "
        "takes [-0.144338, 0.144338] in 2 control periods (a norm of 0.25 rad is 0.144338 on each "
        "of three axes at once); a policy's outputs are taken as full scale [-1, 1], which the "
        "slot's scale makes SI: scale 0.144337 fits"
    )


def test_what_a_slower_policys_delta_is_admitted_as_goes_out_in_range() -> None:
    skill = changed(6, DELTA | {"scale": [1e-3] * 5 + [0.144337]}, HALF_RATE_HZ)
    assert admission_problems(skill, ROBOT, HAL) == []
    routes = resolve_routes(skill.action_contract, ROBOT)
    parts = dispatch(routes, np.ones((1, 6), np.float32), 6)
    (sent,) = control_rows(parts, [6], 2, "hold", 2)
    (block,) = [b for b in HAL.parts[routes[0].part].ranges if b.mode == sent.mode]
    assert np.all(floats(sent.values, 6) <= floats(block.upper))
    assert floats(sent.values, 6)[0, 5] == pytest.approx(floats(block.upper)[5], rel=1e-4)


def test_a_slower_policys_velocities_are_sent_and_compared_as_they_are() -> None:
    twice = TWIST | {"scale": [0.6] + [1e-3] * 5}
    assert problems(6, twice, HAL, HALF_RATE_HZ) == problems(6, twice)
    assert len(problems(6, twice)) == 1


TWIST = {"control_mode": "cartesian_twist", **LEFT}


@pytest.mark.parametrize(("hal", "who"), [(HAL, "HAL"), (None, "robot")])
def test_a_twist_beyond_its_norm_is_refused_at_run_and_before_with_the_norm_and_a_scale_that_fits(
    hal: HalStatus | None, who: str
) -> None:
    assert problems(6, TWIST | {"scale": [1.0] * 3 + [2.0] * 3}, hal) == [
        f"part left_arm cartesian_twist values {values}: full-scale output is [-{full}, {full}], "
        f"the {who} takes [-{share}, {share}] (a norm of {norm} is {share} on each of three axes "
        "at once); a policy's outputs are taken as full scale [-1, 1], which the slot's scale "
        f"makes SI: scale {fits} fits"
        for values, full, share, norm, fits in (
            ("0, 1, 2", "1", "0.57735", "1 m/s", "0.57735"),
            ("3, 4, 5", "2", "1.44338", "2.5 rad/s", "1.44337"),
        )
    ]
    assert problems(6, TWIST | {"scale": [0.57735] * 3 + [1.44337] * 3}, hal) == []


def test_the_scale_and_offset_that_a_refusal_names_are_admitted() -> None:
    joint = {"control_mode": "joint_position", "joint_names": ["left_joint6"]}
    (found,) = problems(1, joint | {"scale": 3.0}, None)
    named = re.search(r"scale (\S+) with offset (\S+) fits", found)
    assert named is not None
    scale, offset = map(float, named.groups())
    assert problems(1, joint | {"scale": scale, "offset": offset}, None) == []


@pytest.mark.parametrize(
    ("mode", "width", "fields"),
    [
        ("joint_position", 1, {"joint_names": ["left_joint4"]}),
        ("dex_hand_joint", 1, {"joint_names": ["right_thumb_joint2"]}),
        ("cartesian_pose", 7, LEFT),
        ("gripper_binary", 1, {"ee": "left_tool"}),
    ],
)
def test_a_mode_that_says_where_may_come_in_si_without_a_scale(
    mode: str, width: int, fields: dict[str, Any]
) -> None:
    assert problems(width, {"control_mode": mode, **fields}) == []


def test_a_scaled_pose_must_stay_in_its_box() -> None:
    slot = {"control_mode": "cartesian_pose", **LEFT, "offset": [0.5, 0.4, 1.0, 0, 0, 0, 0]}
    inside = {"scale": [0.35, 0.6, 0.6, 1, 1, 1, 1]}
    assert problems(7, slot | inside) == []
    outside = {"scale": [0.35, 0.6, 0.61, 1, 1, 1, 1]}
    (found,) = problems(7, slot | outside)
    assert found.startswith(
        "part left_arm cartesian_pose value 2: full-scale output is [0.39, 1.61], "
        "the HAL takes [0.4, 1.6]"
    )


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"scale": 0.5, "offset": 0.5}, []),
        ({"scale": -3.0, "threshold": 0.25}, []),
        ({"scale": 0.5},
         ["part left_gripper gripper_binary value 0: full-scale output is [-0.5, 0.5], "
          "the HAL takes [0, 1]; a policy's outputs are taken as full scale [-1, 1], "
          "which the slot's scale makes SI: scale 0.5 with offset 0.5 fits"]),
    ],
)  # fmt: skip
def test_a_binary_gripper_needs_a_threshold_or_a_scale_to_0_and_1(
    fields: dict[str, Any], found: list[str]
) -> None:
    assert problems(1, {"control_mode": "gripper_binary", "ee": "left_tool", **fields}) == found


def test_the_hals_ranges_have_the_width_of_their_mode() -> None:
    for part, described in zip(ROBOT.parts, HAL.parts, strict=True):
        for block in described.ranges:
            mode = ControlMode(block.mode)
            width = len(part.joints) if mode.is_joint_mode else mode.width(0)
            lower, upper = floats(block.lower), floats(block.upper)
            assert (len(lower), len(upper)) == (width, width), (part.name, mode)
            assert np.all(lower < upper)


def test_the_composite_switch_without_an_arm_is_refused() -> None:
    robot = load_robot("panda_mobile")
    skill = load_skill("oracle-counter-to-cabinet").model_dump(mode="json")
    slots = skill["action_contract"]["slots"]
    assert slots[0]["control_mode"] == "cartesian_delta"
    slots[0] = {"range": [0, 5], "discard": True}
    without = SkillManifest.model_validate(skill)
    assert admission_problems(without, robot) == [
        "composite_mode: part composite belongs to whoever commands an arm, and this skill "
        "commands none"
    ]
