"""The scripted expert does the task from the state vector alone."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bench.equipment.expert_episode import run_episode, true_state
from fairlead.errors import PolicyError
from fairlead.policy import Observation
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy

pytestmark = pytest.mark.simulator


def check(backend: RobosuiteBackend, seed: int, chunk: int = 8) -> bool:
    episode = run_episode(backend, seed, chunk=chunk)
    assert episode.near_tick is not None, episode
    assert episode.near_tick <= 220, episode
    assert episode.base_travel_m > 1.0, episode
    return episode.success_tick is not None


def test_the_can_ends_in_the_cabinet(backend: RobosuiteBackend) -> None:
    assert check(backend, 1)


def test_shorter_chunks_work_too(backend: RobosuiteBackend) -> None:
    assert check(backend, 3, chunk=3)


@pytest.mark.soak
def test_twenty_seeds(backend: RobosuiteBackend) -> None:
    assert sum(check(backend, seed) for seed in range(20)) >= 18


def test_rows_have_checkpoint_format(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    rows = OraclePolicy(horizon=8).infer(Observation(1, true_state(backend), ""))
    assert rows.shape == (8, 12)
    assert rows.dtype == np.float32
    assert np.abs(rows).max() <= 1.0
    assert set(np.unique(rows[:, 6])) <= {-1.0, 1.0}
    assert not rows[:, 10].any()
    assert (rows[:, 11] == -1.0).all()


def test_the_same_observations_give_the_same_bytes_after_a_reset(
    backend: RobosuiteBackend,
) -> None:
    backend.reset(0)
    state, policy = true_state(backend), OraclePolicy()
    first = policy.infer(Observation(5, state, "")).tobytes()
    policy.infer(Observation(13, state, ""))
    policy.reset()
    assert policy.infer(Observation(5, state, "")).tobytes() == first


def test_a_state_of_another_size_is_refused() -> None:
    text = "oracle: expected a state of shape (30,), got (16,)"
    with pytest.raises(PolicyError, match=f"^{re.escape(text)}$"):
        OraclePolicy().infer(Observation(1, np.zeros(16), ""))


@pytest.mark.processes
def test_the_expert_needs_no_simulator() -> None:
    import subprocess
    import sys

    code = (
        "import sys, fairlead_skill_runner.policies.oracle.policy;"
        "print([m for m in ('robosuite', 'mujoco', 'fairlead_hal_sim') if m in sys.modules])"
    )
    out = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=60
    )
    assert out.stdout.strip() == "[]"
