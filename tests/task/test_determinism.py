"""A seed and the commands decide every bit, in any process and after any past."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.expert_episode import commands
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_hal_sim.task import Scene
from tests.task.trajectory import trajectory

pytestmark = pytest.mark.simulator


def test_a_replay_after_another_episode_is_bit_identical(backend: RobosuiteBackend) -> None:
    first = trajectory(backend, 7)
    other = trajectory(backend, 8)
    assert first != other
    assert trajectory(backend, 7) == first


@pytest.mark.processes
def test_another_process_gives_the_same_bits(backend: RobosuiteBackend) -> None:
    here = trajectory(backend, 7)
    process = subprocess.run(
        [sys.executable, "-m", "tests.task.trajectory", "7"],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
        cwd=Path(__file__).parents[2],
    )
    assert process.stdout.strip() == here


def test_looking_changes_no_bit(backend: RobosuiteBackend) -> None:
    def blind(look: bool) -> bytes:
        backend.reset(5)
        for _ in range(20):
            if look:
                backend.transforms()
                backend.static_transforms()
                backend.task()
                backend.read()
            backend.apply(commands(np.full(12, 0.3, dtype=np.float32)))
        return bytes(backend.env.sim.data.qpos.tobytes() + backend.env.sim.data.qvel.tobytes())

    assert blind(True) == blind(False)


def test_each_seed_has_its_own_scene_and_keeps_it(backend: RobosuiteBackend) -> None:
    scenes: dict[int, Scene] = {}
    for seed in (0, 1, 2, 0, 1, 2):
        backend.reset(seed)
        assert scenes.setdefault(seed, backend.env.scene) == backend.env.scene
    assert len({repr(scene) for scene in scenes.values()}) == 3


@pytest.mark.processes
def test_nothing_is_compiled_within_the_first_row() -> None:
    """On a machine's first run that took 12 s: a goal stalled, a realtime robot stood still."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.task.first_row"],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=240,
        check=True,
    )
    before, after = map(int, done.stdout.split())
    assert 0 < before == after
