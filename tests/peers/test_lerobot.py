"""`fairlead export lerobot`: the real lerobot opens it and gives every number back."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fairlead.paths import repo_root
from fairlead_tools.learn.lerobot_export import export_lerobot
from tests.learn.drawn import EXPERT, drawn_dataset, drawn_episode

pytestmark = pytest.mark.processes


def test_lerobot_gives_back_every_recorded_number(tmp_path: Path) -> None:
    python = os.environ.get("LEROBOT", "")
    if not python:
        pytest.skip("LEROBOT names no interpreter with lerobot: LEROBOT=PATH make peers")
    episodes = [drawn_episode(1), drawn_episode(2, 5)]
    folder = drawn_dataset(tmp_path / "data", *episodes)
    export_lerobot(folder, tmp_path / "lerobot", EXPERT, failed=False)
    done = subprocess.run(
        [python, "-m", "tests.peers.read_lerobot", str(tmp_path / "lerobot")],
        cwd=repo_root(), capture_output=True, text=True, timeout=280,
        env=os.environ | {"HF_HUB_OFFLINE": "1", "HF_HOME": str(tmp_path / "hf")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert (told["episodes"], told["fps"], told["tasks"]) == (2, 20, [EXPERT.prompt])
    assert told["episode_index"] == [0] * 12 + [1] * 5
    acted = np.concatenate([one.acted for one in episodes])
    states = np.concatenate([one.states for one in episodes]).astype(np.float32)
    np.testing.assert_array_equal(np.array(told["action"], np.float32), acted)
    np.testing.assert_array_equal(np.array(told["state"], np.float32), states)
    np.testing.assert_allclose(told["mean"], acted.astype(float).mean(0), rtol=1e-6)
