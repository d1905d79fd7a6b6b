"""Torque commands are what the simulator applies, and when they end the arm brakes and stays."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.hal_mujoco.dual_panda import DualPanda

pytestmark = pytest.mark.simulator

TORQUES = np.array([3.0, -6.0, 2.0, -4.0, 0.5, -0.6, 0.3])
PART, TICKS = "right_arm", 6


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("dual_panda")


@pytest.fixture
def world(robot: RobotManifest) -> DualPanda:
    return DualPanda(robot)


def torque(world: DualPanda, values: FloatArray = TORQUES) -> dict[str, PartCommand]:
    return {PART: world.joint_row(ControlMode.JOINT_TORQUE, PART, list(values))}


def plain_mujoco(world: DualPanda, values: FloatArray, ticks: int) -> FloatArray:
    """The arm's joints under these torques, applied from outside, its servos switched off."""
    model = mujoco.MjModel.from_xml_path(str(robot_dir("dual_panda") / "dual_panda.xml"))
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = world.backend._data.qpos, world.backend._data.ctrl
    dofs = [int(model.joint(name).dofadr[0]) for name in world.robot.part(PART).joints]
    data.qfrc_applied[dofs] = values
    for name in world.robot.part(PART).joints:
        model.actuator(name).gainprm[0] = 0.0
        model.actuator(name).biasprm[:] = 0.0
    mujoco.mj_step(model, data, ticks * 25)
    return np.array([data.joint(name).qpos[0] for name in world.robot.part(PART).joints])


def test_torques_do_to_the_arm_what_the_same_forces_from_outside_do(world: DualPanda) -> None:
    expected = plain_mujoco(world, TORQUES, TICKS)
    start = world.positions(PART)
    world.run(torque(world), TICKS)
    assert np.abs(world.positions(PART) - start).max() > 0.1
    np.testing.assert_allclose(world.positions(PART), expected, rtol=0, atol=1e-9)


def test_the_measured_effort_is_the_commanded_torque(world: DualPanda) -> None:
    world.run(torque(world), 1)
    np.testing.assert_array_equal(world.backend.read().efforts[world.joints(PART)], TORQUES)


def test_an_arm_told_no_torque_carries_its_own_weight(world: DualPanda) -> None:
    start = world.positions(PART)
    world.run(torque(world, np.zeros(7)), 40)
    np.testing.assert_allclose(world.positions(PART), start, rtol=0, atol=1e-3)


def test_after_a_torque_the_arm_brakes_where_it_is_and_stays_there(world: DualPanda) -> None:
    world.run(torque(world), TICKS)
    let_go, moving = world.positions(PART), world.backend.read().velocities[world.joints(PART)]
    assert np.abs(moving).max() > 0.5
    world.run({}, 20)
    still = world.backend.read().velocities[world.joints(PART)]
    limits = world.robot.profile("sim").measured
    assert np.all(np.abs(still) < limits["right_joint1"].standstill_per_s)
    np.testing.assert_allclose(world.positions(PART), let_go, rtol=0, atol=1e-4)


def test_joints_without_a_torque_keep_their_servos(world: DualPanda) -> None:
    one = PartCommand(ControlMode.JOINT_TORQUE, "", np.zeros(world.robot.n_dof), ())
    wrist = world.joints(PART)[6]
    one.values[wrist] = 1.0
    start = world.positions(PART)
    world.run({PART: PartCommand(one.mode, "", one.values, (wrist,))}, TICKS)
    moved = world.positions(PART) - start
    assert moved[6] > 0.05 and np.abs(moved[:6]).max() < 0.01, moved


def test_other_parts_and_a_new_episode_have_their_servos(world: DualPanda) -> None:
    left = world.positions("left_arm")
    world.run(torque(world), TICKS)
    np.testing.assert_allclose(world.positions("left_arm"), left, rtol=0, atol=1e-9)
    world.backend.reset(0)
    start = world.positions(PART)
    world.run({}, 0, hold=20)
    np.testing.assert_allclose(world.positions(PART), start, rtol=0, atol=1e-6)
