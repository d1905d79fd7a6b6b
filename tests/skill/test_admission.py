"""May a skill run on a robot: every reason on its refusing side, and the accepted whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from fairlead.errors import ConfigError
from fairlead.modes import GATED_MODES
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.admission import Admission, admission_problems
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead.skill.slots import FIELD_RULES
from tests.skill.mobile_hal import HAL

SKILL = load_skill("oracle-counter-to-cabinet")
ROBOT = load_robot("panda_mobile")


def skill(change: Callable[[dict[str, Any]], None]) -> SkillManifest:
    data = SKILL.model_dump(mode="json")
    change(data)
    return SkillManifest.model_validate(data)


def slot(index: int, **changes: Any) -> Callable[[dict[str, Any]], None]:
    return lambda data: data["action_contract"]["slots"][index].update(changes)


def test_the_shipped_skill_is_admitted_on_its_robot() -> None:
    assert admission_problems(SKILL, ROBOT) == []
    assert admission_problems(SKILL, ROBOT, HAL) == []
    Admission(SKILL, ROBOT).require(HAL)


def test_a_robot_s_gate_files_are_compiled_once_for_all_goals_and_hals_held_against_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compiled: list[str] = []

    def counted(robot: RobotManifest, profile: str) -> str:
        compiled.append(profile)
        return compile_gate_config(robot, profile)

    monkeypatch.setattr("fairlead.skill.limit_overrides.compile_gate_config", counted)
    robot = load_robot("panda_mobile")
    for _ in range(2):
        admission = Admission(SKILL, robot)
        admission.require()
        admission.require(HAL)
    assert compiled == list(robot.safety)
    Admission(SKILL, load_robot("panda_mobile")).require()
    assert compiled == list(robot.safety) * 2, "it was loaded anew, and may be another"
    assert admission.routes == resolve_routes(SKILL.action_contract, ROBOT)


ARM, GRIPPER = "arm takes cartesian_delta", "gripper takes gripper_position"
BASE = "base takes joint_velocity, body_twist"


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            slot(0, ee="left"),
            "slot [0, 5] cartesian_delta: robot panda_mobile has no end effector 'left' "
            "(valid: gripper)",
        ),
        (
            slot(2, joint_names=["base_x", "base_y", "torso"]),
            "slot [7, 9] joint_velocity: robot panda_mobile has no joint 'torso' (valid: base_x, "
            "base_y, base_yaw, panda_joint1, panda_joint2, panda_joint3, "
            "panda_joint4, panda_joint5, "
            "panda_joint6, panda_joint7, panda_gripper)",
        ),
        (
            slot(2, joint_names=["base_x", "base_y", "panda_joint1"]),
            "slot [7, 9] joint_velocity: expected exactly one part of robot "
            "panda_mobile to take it, "
            f"got none ({ARM}; {BASE})",
        ),
        (
            slot(0, control_mode="cartesian_twist"),
            "slot [0, 5] cartesian_twist: expected exactly one part of robot "
            "panda_mobile to take it, "
            f"got none ({ARM}; {GRIPPER})",
        ),
        (
            slot(0, frame="map"),
            "cartesian_delta of part arm: the robot takes no frame 'map' "
            "(valid: base_link; profile sim)",
        ),
        (
            lambda data: data.update(embodiments=["aloha"]),
            "embodiments: made for aloha, not panda_mobile",
        ),
        (
            lambda data: data.update(rate_hz=15.0),
            "rate_hz: expected the robot's 20 Hz or a whole fraction of it, got 15",
        ),
        (
            lambda data: data["state_contract"]["bindings"].update(gripper_qpos_joints=["thumb"]),
            "gripper_qpos_joints: robot panda_mobile measures no joint 'thumb' (valid: "
            + ", ".join(ROBOT.measured_joint_names)
            + ")",
        ),
    ],
)
def test_a_skill_the_robot_cannot_run_is_refused_with_the_reason(
    change: Callable[[dict[str, Any]], None], text: str
) -> None:
    assert admission_problems(skill(change), ROBOT) == [text]


def test_every_reason_is_given_at_once() -> None:
    def change(data: dict[str, Any]) -> None:
        data["rate_hz"] = 15.0
        slot(0, ee="left")(data)
        slot(1, ee="left")(data)

    with pytest.raises(ConfigError) as caught:
        Admission(skill(change), ROBOT).require()
    assert str(caught.value) == (
        "skill oracle-counter-to-cabinet cannot run on robot panda_mobile:\n"
        "  rate_hz: expected the robot's 20 Hz or a whole fraction of it, got 15\n"
        "  slot [0, 5] cartesian_delta: robot panda_mobile has no end effector 'left' "
        "(valid: gripper)\n"
        "  slot [6, 6] gripper_position: robot panda_mobile has no end effector 'left' "
        "(valid: gripper)\n"
        "  try: fairlead skill ls --robot panda_mobile"
    )


def test_a_skill_for_another_robot_is_refused_with_that_and_the_number_of_other_reasons() -> None:
    def change(data: dict[str, Any]) -> None:
        data["embodiments"] = ["aloha"]
        slot(0, ee="left")(data)
        slot(1, ee="left")(data)

    with pytest.raises(ConfigError) as caught:
        Admission(skill(change), ROBOT).require()
    assert str(caught.value).splitlines()[1:-1] == [
        "  embodiments: made for aloha, not panda_mobile",
        "  and 2 more, as on any robot it was not made for",
    ]


def test_an_end_effector_that_is_not_actuated_is_moved_but_not_opened() -> None:
    fixed = ROBOT.model_copy(
        update={"end_effectors": (ROBOT.end_effectors[0].model_copy(update={"actuated": False}),)}
    )
    assert admission_problems(SKILL, fixed) == [
        "slot [6, 6] gripper_position: end effector gripper of robot panda_mobile has "
        "actuated: false"
    ]


def test_every_mode_that_a_slot_can_name_has_a_checker_in_the_gate() -> None:
    assert set(FIELD_RULES) == GATED_MODES


def test_two_modes_for_one_part_in_one_tick_are_refused() -> None:
    def change(data: dict[str, Any]) -> None:
        data["action_contract"]["slots"][3:4] = [
            {"range": [10, 10], "control_mode": "body_twist", "axes": [5]}
        ]

    assert admission_problems(skill(change), ROBOT) == [
        "slot [10, 10] body_twist: part base is already commanded in joint_velocity"
    ]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            slot(0, scale=1.0),  # the scale was forgotten: metres instead of normalised output
            "part arm cartesian_delta values 0, 1, 2: full-scale output is [-1, 1], "
            "the HAL takes [-0.05, 0.05]",
        ),
        (
            slot(1, offset=[0.05]),
            "part gripper gripper_position value 0: full-scale output is [0.01, 0.09], "
            "the HAL takes [0, 0.08]",
        ),
        (
            slot(2, joint_names=["base_yaw", "base_y", "base_x"]),
            "part base joint_velocity value 0: full-scale output is [-1.5, 1.5], "
            "the HAL takes [-1, 1]",
        ),
    ],
)
def test_full_scale_output_beyond_the_hals_range_is_refused_with_both_numbers(
    change: Callable[[dict[str, Any]], None], text: str
) -> None:
    found = admission_problems(skill(change), ROBOT, HAL)
    assert [one for one in found if one.startswith(text)]


def test_a_hal_that_orders_the_robot_otherwise_is_refused_with_both_orders() -> None:
    other = msgspec.structs.replace(
        HAL, parts=(HAL.parts[0], HAL.parts[2], HAL.parts[1], HAL.parts[3])
    )
    assert admission_problems(SKILL, ROBOT, other) == [
        "part order: the robot's manifest says arm, gripper, base, composite, "
        "the HAL says arm, base, gripper, composite"
    ]


def test_a_hal_of_another_robot_is_refused_with_what_brings_a_changed_one_up() -> None:
    other = msgspec.structs.replace(HAL, robot_hash=bytes(32), period_ns=20_000_000)
    assert admission_problems(SKILL, ROBOT, other) == [
        f"robot hash: the robot's manifest says {ROBOT.robot_hash.hex()[:16]}, "
        "the HAL says 0000000000000000; robot.yaml or its description is not what the HAL "
        "started with: fairlead robot compile panda_mobile, then fairlead down and fairlead up",
        "control period [ns]: the robot's manifest says 50000000, the HAL says 20000000",
    ]


def test_a_mode_the_hal_does_not_offer_is_refused() -> None:
    bare = msgspec.structs.replace(HAL.parts[3], ranges=())
    other = msgspec.structs.replace(HAL, parts=(*HAL.parts[:3], bare))
    assert admission_problems(SKILL, ROBOT, other) == [
        "part composite: the HAL does not offer composite_mode"
    ]


@pytest.mark.parametrize(
    ("image", "text"),
    [
        (
            {"camera": "wrist", "width": 128, "height": 128},
            "images: eye needs camera 'wrist' (valid: front)",
        ),
        (
            {"camera": "front", "width": 256, "height": 128},
            "images: eye expects 256 x 128 pixels, camera front gives 128 x 128",
        ),
    ],
)
def test_a_camera_that_is_missing_or_of_another_size_is_refused(
    image: dict[str, Any], text: str
) -> None:
    wanted = skill(lambda data: data.update(images={"eye": image}))
    assert admission_problems(wanted, ROBOT, HAL) == [text]


def test_slots_of_one_part_become_one_route() -> None:
    def change(data: dict[str, Any]) -> None:
        data["action_contract"]["slots"][2:3] = [
            {
                "range": [7, 7],
                "control_mode": "joint_velocity",
                "joint_names": ["base_yaw"],
                "scale": 1.5,
            },
            {
                "range": [8, 9],
                "control_mode": "joint_velocity",
                "joint_names": ["base_x", "base_y"],
            },
        ]

    routes = resolve_routes(skill(change).action_contract, ROBOT)
    assert [route.part_name for route in routes] == ["arm", "gripper", "base", "composite"]
    assert routes[2].sources == (7, 8, 9)
    assert routes[2].columns == (2, 0, 1)
    assert routes[2].scale == (1.5, 1.0, 1.0)
    assert routes[2].active == (0, 1, 2)


def test_a_skill_that_asks_for_more_than_the_protocol_allows_is_refused() -> None:
    greedy = skill(lambda data: data.update(horizon=65, age_max_ticks=11))
    assert admission_problems(greedy, ROBOT) == [
        "horizon: expected at most 64, got 65 (profile sim)",
        "age_max_ticks: expected at most 10, got 11 (profile sim)",
    ]
