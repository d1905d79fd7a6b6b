"""What a person is told to do about a skill that may not run."""

from __future__ import annotations

import msgspec
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import HalPart, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from tests.skill.mobile_hal import HAL

SPEEDS = ModeRange(
    mode=ControlMode.CARTESIAN_DELTA, lower=pack_floats([-1.0] * 6), upper=pack_floats([1.0] * 6)
)


def test_of_a_mode_that_only_another_hal_of_the_robot_offers_its_deployments_are_named() -> None:
    """`fairlead skill ls` lists the skill as admitted: that would lead in a circle."""
    skill, robot = load_skill("ur5e-reach"), load_robot("ur5e")
    parts = [
        HalPart(name=part.name, simulator_part="", joints=part.joints, ranges=(SPEEDS,))
        for part in robot.parts
    ]
    other = msgspec.structs.replace(
        HAL, robot=robot.id, robot_hash=robot.robot_hash, period_ns=robot.tick_period_ns,
        joints=robot.joint_names, passive_joints=robot.passive_joint_names, parts=tuple(parts),
    )  # fmt: skip
    with pytest.raises(ConfigError) as caught:
        Admission(skill, robot).require(other)
    _, arm, *_, fix = str(caught.value).splitlines()
    assert arm == "  part arm: the HAL does not offer joint_position, it offers cartesian_delta"
    assert fix == (
        "  try: fairlead down, then fairlead up another deployment of ur5e: ur5e_mujoco, "
        "ur5e_robosuite, ur5e_robosuite_cameras"
    )
