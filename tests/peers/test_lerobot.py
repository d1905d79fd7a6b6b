"""`fairlead export lerobot`: the real lerobot opens it and gives every number back."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fairlead_tools.learn.dataset import add, begin
from fairlead_tools.learn.lerobot_export import export_lerobot
from tests.learn.drawn import (
    CLONE,
    EXPERT,
    drawn_dataset,
    drawn_episode,
    drawn_pictures,
    drawn_sight,
)
from tests.peers.environment import by_lerobot, lerobot

pytestmark = pytest.mark.processes


def test_lerobot_gives_back_every_recorded_number(tmp_path: Path) -> None:
    lerobot()
    episodes = [drawn_episode(1), drawn_episode(2, 5)]
    folder = drawn_dataset(tmp_path / "data", *episodes)
    export_lerobot(folder, tmp_path / "lerobot", EXPERT, failed=False)
    said = by_lerobot(tmp_path, "read_lerobot", tmp_path / "lerobot")
    told = json.loads(said.splitlines()[-1])
    assert (told["episodes"], told["fps"], told["tasks"]) == (2, 20, [EXPERT.prompt])
    assert told["episode_index"] == [0] * 12 + [1] * 5
    acted = np.concatenate([one.acted for one in episodes])
    states = np.concatenate([one.states for one in episodes]).astype(np.float32)
    np.testing.assert_array_equal(np.array(told["action"], np.float32), acted)
    np.testing.assert_array_equal(np.array(told["state"], np.float32), states)
    np.testing.assert_allclose(told["mean"], acted.astype(float).mean(0), rtol=1e-6)


def test_lerobot_is_told_which_ticks_of_a_deployed_episode_were_released(tmp_path: Path) -> None:
    lerobot()
    released = np.arange(12) % 3 > 0
    header = begin(tmp_path / "data", EXPERT, "panda_mobile", 0.0, deployed=True)
    add(tmp_path / "data", header, replace(drawn_episode(1), released=released))
    export_lerobot(tmp_path / "data", tmp_path / "lerobot", EXPERT, failed=False)
    said = by_lerobot(tmp_path, "read_lerobot", tmp_path / "lerobot")
    assert json.loads(said.splitlines()[-1])["released"] == released.tolist()


def test_lerobot_gives_back_every_pixel_of_recorded_pictures(tmp_path: Path) -> None:
    lerobot()
    folder, key = drawn_pictures(tmp_path / "data", 3, 4), "observation.images.eye"
    export_lerobot(folder, tmp_path / "lerobot", CLONE, failed=False)
    said = by_lerobot(tmp_path, "read_lerobot", tmp_path / "lerobot")
    told = json.loads(said.splitlines()[-1])
    assert (told["episodes"], told["fps"], told["cameras"]) == (2, 20, [key])
    recorded = np.concatenate([drawn_sight(seed).pictures["eye"] for seed in (3, 4)])
    pixels = np.array(told[key], np.uint8).reshape(-1, 3, 64, 64)
    np.testing.assert_array_equal(np.moveaxis(pixels, 1, -1), recorded)
    mean = (recorded / 255).mean((0, 1, 2)).reshape(3, 1, 1)
    np.testing.assert_allclose(told[f"{key} mean"], mean, rtol=1e-6)
