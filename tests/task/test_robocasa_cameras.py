"""RoboCasa's two cameras over the shoulders: where they hang; physics does not see them."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_hal_sim.task import mobile_pick_place
from tests.task.trajectory import trajectory

pytestmark = pytest.mark.simulator

SIDES = {"robot0_agentview_left": 1.0, "robot0_agentview_right": -1.0}


@pytest.mark.parametrize("camera", SIDES)
def test_a_camera_hangs_behind_and_beside_the_arm_and_looks_at_what_it_does(
    camera: str, backend: RobosuiteBackend
) -> None:
    backend.reset(0)
    sim = backend.env.sim
    index = sim.model.camera_name2id(camera)
    arm = sim.data.body_xpos[sim.model.body_name2id("mobilebase0_support")]
    np.testing.assert_allclose(
        sim.data.cam_xpos[index] - arm, [-0.5, 0.35 * SIDES[camera], 1.05], atol=1e-6
    )
    looks_at = -sim.data.cam_xmat[index].reshape(3, 3)[:, 2]
    down_deg = np.degrees(np.arcsin(-looks_at[2]))
    inwards_deg = np.degrees(np.arctan2(-SIDES[camera] * looks_at[1], looks_at[0]))
    assert (round(down_deg, 1), round(inwards_deg, 1)) == (32.5, 12.1)
    assert sim.model.cam_fovy[index] == 60.0


def test_the_cameras_move_with_the_base(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    sim = backend.env.sim
    index = sim.model.camera_name2id("robot0_agentview_left")
    before = sim.data.cam_xpos[index].copy()
    sim.data.set_joint_qpos("mobilebase0_joint_mobile_forward", 0.7)
    sim.forward()
    assert np.linalg.norm(sim.data.cam_xpos[index] - before) > 0.5


def test_no_bit_of_the_physics_knows_of_the_cameras(
    backend: RobosuiteBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mobile_pick_place, "mount_robocasa_cameras", lambda model: None)
    blind = RobosuiteBackend(SimulatorOptions())
    assert "robot0_agentview_left" not in blind.env.sim.model.camera_names
    assert trajectory(blind, 7) == trajectory(backend, 7)
    blind.close()


def test_a_robot_without_an_omron_base_does_not_get_them() -> None:
    fixed = RobosuiteBackend(SimulatorOptions(robot="Panda"))
    assert not SIDES.keys() & set(fixed.env.sim.model.camera_names)
    fixed.close()
