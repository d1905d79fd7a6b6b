"""What the composite switch does in the simulator, measured."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from bench.equipment.expert_episode import true_state
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from tests.task.arm_shift import arm_shift_after_turning, mode

pytestmark = pytest.mark.simulator


def test_minus_one_holds_the_achieved_arm_pose_so_the_arm_stays_behind(
    backend: RobosuiteBackend,
) -> None:
    assert arm_shift_after_turning(backend, -1.0) > 0.10


def test_plus_one_holds_the_desired_arm_pose_so_the_arm_comes_back(
    backend: RobosuiteBackend,
) -> None:
    assert arm_shift_after_turning(backend, 1.0) < 0.01


def test_plus_one_in_the_first_tick_is_held_back_and_said_so(
    backend: RobosuiteBackend, caplog: pytest.LogCaptureFixture
) -> None:
    backend.reset(0)
    before = true_state(backend)[:3]
    with caplog.at_level(logging.WARNING):
        backend.apply(mode(1.0))
    assert backend.last_packed is not None
    assert backend.last_packed[-1] == -1.0
    assert caplog.messages == ["composite_mode 1 held at -1 in the first tick"]
    for _ in range(20):
        backend.apply(mode(1.0))
    assert backend.last_packed[-1] == 1.0
    assert np.linalg.norm(true_state(backend)[:3] - before) < 0.01


def test_without_the_guard_the_first_tick_throws_the_arm(backend: RobosuiteBackend) -> None:
    """The reason for the guard; if this fails, the simulator was mended."""
    backend.reset(0)
    before = true_state(backend)[:3]
    action = np.zeros(12, dtype=np.float32)
    action[-1] = 1.0
    for _ in range(40):
        backend.env.step(action.copy())
    assert np.linalg.norm(true_state(backend)[:3] - before) > 0.3
