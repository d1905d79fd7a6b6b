"""The three RoboCasa skills: what they declare, where they are admitted, where not."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import HalCamera
from fairlead.paths import ROBOTS_VARIABLE, robot_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission, admission_problems
from fairlead.skill.image_spec import ImageSpec
from fairlead.skill.manifest import load_skill
from tests.skill.mobile_hal import HAL

ROBOCASA = ("rldx1-ft-rc365-nf4", "rldx-robocasa", "pi05-robocasa365-human300-nf4")
MOBILE = load_robot("panda_mobile")
CAMERAS = ("robot0_agentview_left", "robot0_agentview_right", "robot0_eye_in_hand")


@pytest.mark.parametrize("name", ROBOCASA)
def test_a_robocasa_skill_routes_the_base_discards_the_torso_and_carries_the_mode(
    name: str,
) -> None:
    contract = load_skill(name).action_contract
    assert contract.dim == 12
    assert [(s.first, s.last, s.control_mode) for s in contract.slots] == [
        (0, 5, "cartesian_delta"),
        (6, 6, "gripper_position"),
        (7, 9, "joint_velocity"),
        (10, 10, None),
        (11, 11, "composite_mode"),
    ]
    assert contract.slots[2].joint_names == ("base_x", "base_y", "base_yaw")
    fits = [(s.clip, s.threshold) for s in contract.slots]
    assert fits == [((-1, 1), None), (None, 0.5), ((-1, 1), None), (None, None), (None, 0.5)]
    plain = [s.model_copy(update={"clip": None, "threshold": None}) for s in contract.slots]
    expert = load_skill("oracle-counter-to-cabinet").action_contract
    assert contract.model_copy(update={"slots": tuple(plain)}) == expert


@pytest.mark.parametrize("name", ROBOCASA)
def test_a_robocasa_skill_binds_the_frames_its_data_was_recorded_in(name: str) -> None:
    state = load_skill(name).state_contract
    assert (state.layout, state.dim) == ("human300_16d" if "pi05" in name else "rc365", 16)
    bound = state.bindings
    assert (bound.eef_frame, bound.eef_rotation_frame) == ("grip_site", "panda_hand")
    assert (bound.base_frame, bound.world_frame) == ("base_site", "map")
    assert bound.gripper_qpos_joints == ("panda_finger_joint1", "panda_finger_joint2")


@pytest.mark.parametrize("name", ROBOCASA)
def test_a_robocasa_skill_is_admitted_on_its_robot_and_needs_its_cameras_once_it_runs(
    name: str,
) -> None:
    skill = load_skill(name)
    assert admission_problems(skill, MOBILE) == []
    cameras = tuple(HalCamera(name=c, width=256, height=256, period_ticks=2) for c in CAMERAS)
    with_cameras = msgspec.structs.replace(HAL, cameras=cameras)
    assert admission_problems(skill, MOBILE, with_cameras) == []
    without = msgspec.structs.replace(HAL, cameras=cameras[1:])
    assert admission_problems(skill, MOBILE, without) == [
        f"images: {next(iter(skill.images))} needs camera 'robot0_agentview_left' "
        "(valid: robot0_agentview_right, robot0_eye_in_hand)"
    ]


def test_a_skill_whose_cameras_are_off_is_refused_with_the_deployment_that_has_them() -> None:
    without = msgspec.structs.replace(HAL, cameras=())
    with pytest.raises(ConfigError) as caught:
        Admission(load_skill("rldx-robocasa"), MOBILE).require(without)
    assert str(caught.value) == (
        "skill rldx-robocasa cannot run on robot panda_mobile:\n"
        "  images: left_view needs camera 'robot0_agentview_left' (valid: none)\n"
        "  images: right_view needs camera 'robot0_agentview_right' (valid: none)\n"
        "  images: wrist_view needs camera 'robot0_eye_in_hand' (valid: none)\n"
        "  try: fairlead down, then fairlead up panda_mobile_sim_cameras, which has these cameras"
    )


def test_a_camera_too_slow_for_the_frames_a_picture_wants_is_refused_with_how_often() -> None:
    skill = load_skill("rldx-robocasa")
    left = ImageSpec(camera=CAMERAS[0], width=256, height=256, deltas=(-6, -4, -2, 0))
    skill = skill.model_copy(update={"images": {"left": left}})
    for period_ticks, fits in [(1, True), (2, True), (4, False), (3, False)]:
        camera = HalCamera(name=CAMERAS[0], width=256, height=256, period_ticks=period_ticks)
        running = msgspec.structs.replace(HAL, cameras=(camera,))
        wanted = [
            "images: left wants frames at deltas -6, -4, -2, 0, so one every 2 ticks or a whole "
            "fraction of that; camera robot0_agentview_left gives one every "
            f"{period_ticks} (its period_ticks)"
        ]
        assert admission_problems(skill, MOBILE, running) == ([] if fits else wanted)
        if not fits:
            with pytest.raises(ConfigError, match="try: .* fairlead up panda_mobile_sim_cameras"):
                Admission(skill, MOBILE).require(running)


def test_where_nothing_renders_the_refusal_sends_to_the_hals_log() -> None:
    off = msgspec.structs.replace(HAL, cameras=(), detail="cameras off: no renderer was started")
    with pytest.raises(ConfigError) as caught:
        Admission(load_skill("rldx-robocasa"), MOBILE).require(off)
    assert str(caught.value).endswith(
        "try: fairlead logs, which says why; the HAL: cameras off: no renderer was started"
    )


def test_a_camera_that_no_deployment_has_is_refused_with_the_option_that_switches_it_on() -> None:
    skill = load_skill("rldx-robocasa")
    attic = {"attic": ImageSpec(camera="attic", width=64, height=64)}
    with pytest.raises(ConfigError) as caught:
        Admission(skill.model_copy(update={"images": attic}), MOBILE).require(HAL)
    assert str(caught.value).endswith(
        "try: options.cameras of the HAL in the deployment file switches cameras on"
    )


@pytest.mark.parametrize("name", ROBOCASA)
def test_a_robocasa_skill_is_dropped_with_reasons_on_a_robot_without_a_base(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "fixed").symlink_to(robot_dir(MOBILE.id))
    monkeypatch.setenv(ROBOTS_VARIABLE, str(tmp_path))
    fixed = MOBILE.model_copy(
        update={
            "id": "fixed",
            "parts": tuple(part for part in MOBILE.parts if part.name in ("arm", "gripper")),
            "safety": {},
        }
    )
    problems = "\n".join(admission_problems(load_skill(name), fixed))
    assert "embodiments: made for panda_mobile, not fixed" in problems
    assert (
        "slot [7, 9] joint_velocity: expected exactly one part of robot fixed to take it, got none"
        in problems
    )
    assert "slot [11, 11] composite_mode: expected exactly one part" in problems
