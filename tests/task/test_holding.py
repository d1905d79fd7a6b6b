"""Parts without commands stand still, and a grasp is kept."""

from __future__ import annotations

import numpy as np
import pytest

from bench.equipment.expert_episode import commands, true_state
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

pytestmark = pytest.mark.simulator

TICKS_PER_MINUTE = 1200
STANDSTILL = 0.01
"""rad/s or m/s: slower counts as standing still."""

ARM = slice(3, 10)
BRAKES = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
"""Declared for the arm's joints [rad/s2]."""
DECLARED = 2.175
"""The slowest joints' speed limit [rad/s]."""


def wait_for_standstill(backend: RobosuiteBackend) -> int:
    """Hold until no joint moves any more; the number of held ticks."""
    for tick in range(200):
        if np.abs(backend.read().velocities).max() < STANDSTILL:
            return tick
        backend.apply({})
    raise AssertionError("never still")


@pytest.mark.thorough
def test_a_held_robot_drifts_less_than_5_mm_in_a_minute(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    for _ in range(20):  # away from the start pose first
        backend.apply(commands(np.array([0.5, 0.4, -0.3, 0.1, 0.2, 0.3, 1, 0.6, 0.4, 0.5, 0, -1])))
    ticks = wait_for_standstill(backend)
    assert ticks <= 40
    eef, pose = true_state(backend)[:3], backend.read().positions
    for _ in range(TICKS_PER_MINUTE):
        backend.apply({})
    drift = true_state(backend)[:3] - eef
    moved = backend.read().positions - pose
    assert np.linalg.norm(drift) < 0.005
    assert np.abs(moved[:2]).max() < 0.005
    assert abs(moved[2]) < 0.005
    assert abs(moved[13]) < 0.001  # torso


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_arm_whose_rows_end_at_full_scale_brakes_as_its_joints_are_declared_to(
    backend: RobosuiteBackend, seed: int
) -> None:
    backend.reset(seed)
    corner = np.where(np.random.default_rng(seed).random(6) < 0.5, -1.0, 1.0)
    for _ in range(10):
        backend.apply(commands(np.array([*corner, -1, 0, 0, 0, 0, -1])))
    before = backend.read()
    assert np.abs(before.velocities[ARM]).max() > 1.0
    assert wait_for_standstill(backend) <= 12
    went = backend.read().positions[ARM] - before.positions[ARM]
    speeds = before.velocities[ARM]
    assert np.all(np.abs(went) <= speeds**2 / (2.0 * BRAKES) + 0.02)


def fastest_at_full_scale(backend: RobosuiteBackend, seed: int) -> float:
    """Of any joint of the arm [rad/s], told one corner of all axes for a second."""
    backend.reset(seed)
    corner = np.where(np.random.default_rng(seed).random(6) < 0.5, -1.0, 1.0)
    fastest = 0.0
    for _ in range(20):
        backend.apply(commands(np.array([*corner, -1, 0, 0, 0, 0, -1])))
        fastest = max(fastest, float(np.abs(backend.read().velocities[ARM]).max()))
    return fastest


def test_full_scale_deltas_move_joints_as_fast_as_in_training_unless_they_are_guarded(
    backend: RobosuiteBackend,
) -> None:
    guarded = RobosuiteBackend(SimulatorOptions(joint_speed_guard=1.5))
    try:
        speeds = [[fastest_at_full_scale(b, seed) for b in (guarded, backend)] for seed in range(3)]
    finally:
        guarded.close()
    assert all(1.0 < slowed < DECLARED and slowed < plain for slowed, plain in speeds)
    assert max(plain for _, plain in speeds) > 1.01 * DECLARED


def test_a_base_that_drives_carries_a_held_arm_along(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    backend.apply({})
    arm = backend.read().positions[ARM]
    furthest = 0.0
    for tick in range(60):
        there = -1.0 if tick // 6 % 2 else 1.0
        rates = np.append(there * np.array([1.0, -1.0, 1.5]), np.zeros(8))
        backend.apply({"base": PartCommand(ControlMode.JOINT_VELOCITY, "", rates, (0, 1, 2))})
        furthest = max(furthest, float(np.abs(backend.read().positions[ARM] - arm).max()))
    assert furthest < 0.05


def test_a_hold_after_zeros_that_drifted_keeps_the_joints_where_it_found_them(
    backend: RobosuiteBackend,
) -> None:
    backend.reset(0)
    zero = PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", np.zeros(6), ())
    backend.apply({"arm": zero})
    for _ in range(5):
        backend.apply({})
    rates = np.append(np.array([1.0, 0.0, 0.0]), np.zeros(8))
    start = backend.read().positions[ARM]
    for _ in range(6):
        base = PartCommand(ControlMode.JOINT_VELOCITY, "", rates, (0, 1, 2))
        backend.apply({"base": base, "arm": zero})
    for _ in range(6):  # the base has come to rest, the arm is where the zeros left it
        backend.apply({"arm": zero})
    before = backend.read()
    assert np.abs(before.positions[ARM] - start).max() > 0.015
    for _ in range(40):
        backend.apply({})
    went = backend.read().positions[ARM] - before.positions[ARM]
    assert np.all(np.abs(went) <= before.velocities[ARM] ** 2 / (2.0 * BRAKES) + 0.01)


def test_a_closing_gripper_goes_on_closing_without_commands(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    close = PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([0.0]), ())
    backend.apply({"gripper": close})
    for _ in range(20):
        backend.apply({})
    assert backend.read().positions[10] < 0.002


def test_a_reset_forgets_the_gripper_command(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    close = PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([0.0]), ())
    backend.apply({"gripper": close})
    backend.reset(0)
    for _ in range(20):
        backend.apply({})
    assert backend.read().positions[10] == pytest.approx(0.0417, abs=0.003)
