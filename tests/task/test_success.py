"""When the task says it is done, and when it does not."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

pytestmark = pytest.mark.simulator


def put_can(backend: RobosuiteBackend, position: FloatArray, velocity: float = 0.0) -> bool:
    """Stand the can at a world position [m] and ask for success."""
    env = backend.env
    joint = env.can.joints[0]
    env.sim.data.set_joint_qpos(joint, np.array([*position, 1.0, 0.0, 0.0, 0.0]))
    env.sim.data.set_joint_qvel(joint, np.array([velocity, 0.0, 0.0, 0.0, 0.0, 0.0]))
    env.sim.forward()
    reading = backend.task()
    assert reading is not None
    return reading.success


@pytest.fixture
def shelf(backend: RobosuiteBackend) -> FloatArray:
    """Where the centre of a can on the shelf belongs, in the world [m]."""
    backend.reset(0)
    goal = next(f for f in backend.transforms() if f.child == "goal")
    return np.asarray(goal.translation + np.array([0.0, 0.0, 0.05]))


def test_a_can_at_rest_in_the_cabinet_is_success(
    backend: RobosuiteBackend, shelf: FloatArray
) -> None:
    assert put_can(backend, shelf)


def test_a_can_on_the_counter_is_none(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    reading = backend.task()
    assert reading is not None
    assert not reading.success


@pytest.mark.parametrize("offset", [(0.5, 0, 0), (0, -0.4, 0), (0, 0, 0.6), (0, 0, -0.3)])
def test_a_can_beside_in_front_above_or_below_is_none(
    backend: RobosuiteBackend, shelf: FloatArray, offset: tuple[float, float, float]
) -> None:
    assert not put_can(backend, shelf + np.array(offset))


def test_a_moving_can_is_none(backend: RobosuiteBackend, shelf: FloatArray) -> None:
    assert not put_can(backend, shelf, velocity=0.05)


def test_a_can_the_gripper_is_still_at_is_none(
    backend: RobosuiteBackend, shelf: FloatArray
) -> None:
    env = backend.env
    assert put_can(backend, shelf)
    grip = env.sim.data.site_xpos[env.robots[0].eef_site_id["right"]]
    to_gripper = np.array(grip) - shelf
    env.sim.data.set_mocap_pos("cabinet", env.sim.data.get_mocap_pos("cabinet") + to_gripper)
    assert not put_can(backend, np.array(grip))
