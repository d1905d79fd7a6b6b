"""The sign of the hand's rotation in the world, beside plain robosuite's, as the base turns."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.service_options import check_options
from fairlead.paths import deployment_path
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead.skill.state_contract import StateContract
from fairlead_hal_sim import HalSimOptions, RobosuiteBackend
from fairlead_state_assembler import LocalAssembler
from fairlead_tools.parity.local_episode import observe

pytestmark = pytest.mark.simulator
CONTRACT = StateContract.model_validate(
    {
        "layout": "panda_omron_53d",
        "dim": 53,
        "bindings": {
            "eef_frame": "grip_site",
            "eef_rotation_frame": "panda_hand",
            "base_frame": "base_site",
            "world_frame": "map",
            "gripper_qpos_joints": ["panda_finger_joint1", "panda_finger_joint2"],
        },
    }
)
SKILL = load_skill("gr00t-robocasa").model_copy(update={"state_contract": CONTRACT})
FIRST = 21  # of end_effector_rotation_absolute
YAWS = np.linspace(-3.1, 3.1, 32)
ROOTS = (0.0, 2.0, 3.1, float(np.pi), -3.1)
"""Yaws at which the robot stands in its world, as RoboCasa puts it before a counter [rad]."""


@pytest.fixture(scope="module")
def backend() -> Iterator[RobosuiteBackend]:
    deployment, robot = load_deployment(deployment_path("panda_mobile_sim")), "panda_mobile"
    options = check_options(deployment, deployment.hal, HalSimOptions)
    loaded = load_robot(robot)
    with closing(RobosuiteBackend(options, loaded.tick_period_ns, loaded)) as made:
        made.reset(3)
        yield made


def rotation(backend: RobosuiteBackend, assembler: LocalAssembler) -> tuple[Any, Any]:
    """The layout's and robosuite's own, both xyzw."""
    backend.env.sim.forward()
    ours = observe(assembler, backend, SKILL)[FIRST : FIRST + 4]
    return ours, backend.env._get_observations(force_update=True)["robot0_eef_quat"]


@pytest.mark.parametrize("root", ROOTS)
def test_it_is_robosuite_s_at_every_yaw_of_the_base_wherever_the_robot_stands(
    backend: RobosuiteBackend, root: float
) -> None:
    sim, assembler = backend.env.sim, LocalAssembler(load_robot("panda_mobile"))
    model, state = sim.model, sim.get_state()
    joint = model.get_joint_qpos_addr("mobilebase0_joint_mobile_yaw")
    arm = [model.get_joint_qpos_addr(f"robot0_joint{number}") for number in range(1, 8)]
    home, body = sim.data.qpos[arm].copy(), model.body_name2id("robot0_base")
    stood, rng = model.body_quat[body].copy(), np.random.default_rng(0)
    turned = np.array([np.cos(root / 2), 0.0, 0.0, np.sin(root / 2)]) * np.sign(np.cos(root / 2))
    try:
        model.body_quat[body] = turned
        for yaw in YAWS:
            sim.data.qpos[joint] = yaw
            sim.data.qpos[arm] = home + rng.uniform(-0.5, 0.5, 7)
            ours, robosuites = rotation(backend, assembler)
            np.testing.assert_allclose(ours, robosuites, atol=1e-6)
    finally:
        model.body_quat[body] = stood
        sim.set_state(state)
