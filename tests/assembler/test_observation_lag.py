"""Why state vectors come from joints and transforms, not from robosuite's observations."""

from typing import Any

import mujoco
import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

PHYSICS_STEP_S = 0.002


class RecordedSteps:
    """Keeps the joint positions that every physics step began with."""

    def __init__(self, sim: Any) -> None:
        self.began_with: list[FloatArray] = []
        integrate = sim.step2

        def step2() -> None:
            self.began_with.append(np.array(sim.data.qpos))
            integrate()

        sim.step2 = step2


def grip_site(env: Any, qpos: FloatArray) -> FloatArray:
    """Where the grip site is at given joint positions."""
    model = env.sim.model._model
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return np.array(data.site_xpos[env.robots[0].eef_site_id["right"]])


@pytest.mark.simulator
def test_observed_gripper_is_where_it_was_one_physics_step_before_the_observed_joints() -> None:
    backend = RobosuiteBackend(SimulatorOptions(seed=0))
    env = backend.env
    assert env.model_timestep == PHYSICS_STEP_S
    steps, forward = RecordedSteps(env.sim), np.zeros(env.action_dim)
    forward[backend._action_map.slot("base").first] = 1.0
    for _ in range(4):
        observed = env.step(forward.copy())[0]
    newest = np.array(env.sim.data.qpos)
    arm = env.robots[0]._ref_joint_pos_indexes
    assert np.array_equal(observed["robot0_joint_pos"], newest[arm])
    previous = steps.began_with[-1]
    assert np.allclose(observed["robot0_eef_pos"], grip_site(env, previous), atol=1e-12)
    behind = np.linalg.norm(grip_site(env, newest) - observed["robot0_eef_pos"])
    assert 1e-4 < behind < 3e-3  # 2 ms at the base's speed: more than a layout may be off
    backend.close()
