"""Datasets whose numbers are drawn: states that a mobile pick could have, and rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fairlead.skill.manifest import load_skill
from fairlead_tools.learn.dataset import Episode, add, begin

EXPERT, CLONE = load_skill("oracle-counter-to-cabinet"), load_skill("bc-reach-cube")


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


def drawn_sight(seed: int, ticks: int = 40) -> Episode:
    """Pictures and states that are drawn; the label of a tick is where its red patch is."""
    rng = np.random.default_rng(seed)
    frames = rng.integers(180, 255, (ticks, 64, 64, 3), np.uint8)
    labels = np.zeros((ticks, 4, 7), np.float32)
    for frame, label in zip(frames, labels, strict=True):
        row, column = rng.integers(4, 56, 2)
        frame[row : row + 6, column : column + 6] = (200, 30, 30)
        label[:, 0], label[:, 1], label[:, 6] = row / 64, column / 64, -1
    states = rng.normal(size=(ticks, 8))
    return Episode(seed, True, states, labels[:, 0], labels[:, 0], {"eye": frames}, labels)


def drawn_pictures(folder: Path, *seeds: int, expert: str = "oracle-reach-cube") -> Path:
    header = begin(folder, CLONE, "ur5e", 0.0, expert)
    for seed in seeds:
        header = add(folder, header, drawn_sight(seed))
    return folder
