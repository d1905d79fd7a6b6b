"""Datasets whose numbers are drawn: states that a mobile pick could have, and rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fairlead.skill.manifest import load_skill
from fairlead_tools.learn.dataset import Episode, add, begin

EXPERT = load_skill("oracle-counter-to-cabinet")


def quaternion(yaw: float) -> list[float]:
    return [0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2))]


def drawn_state(rng: np.random.Generator) -> np.ndarray:
    hand, base = rng.uniform([0.4, -0.2, 0.1], [0.6, 0.2, 0.4]), rng.uniform(-0.1, 0.1, 3)
    thing, goal = rng.uniform([0.4, -0.2, 0.0], [0.7, 0.2, 0.1]), rng.uniform(-1, 1, 3)
    return np.array(
        [*hand, 0.0, 1.0, 0.0, 0.0, *base, *quaternion(base[2]), 0.02, -0.02,
         *thing, *quaternion(rng.uniform(-1, 1)), *goal, *quaternion(1.5)]
    )  # fmt: skip


def drawn_episode(seed: int, ticks: int = 12, succeeded: bool = True) -> Episode:
    rng = np.random.default_rng(seed)
    rows = rng.uniform(-1, 1, (ticks, 12)).astype(np.float32)
    states = np.array([drawn_state(rng) for _ in range(ticks)])
    return Episode(seed, succeeded, states, rows, rows / np.float32(2))


def drawn_dataset(folder: Path, *episodes: Episode) -> Path:
    header = begin(folder, EXPERT, "panda_mobile", 0.0)
    for episode in episodes:
        header = add(folder, header, episode)
    return folder
