"""LeRobotDataset v3: the files by others' readers; `make peers` opens them with lerobot."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pyarrow import parquet

from fairlead.errors import ConfigError
from fairlead_tools.learn.dataset import FILE
from fairlead_tools.learn.lerobot_export import export_lerobot
from tests.learn.drawn import (
    CLONE,
    EXPERT,
    drawn_dataset,
    drawn_episode,
    drawn_pictures,
    drawn_sight,
)

EPISODES = (drawn_episode(1), drawn_episode(2, succeeded=False), drawn_episode(3, 5))


def test_frames_are_the_recorded_numbers_and_indices_count_on(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "d", *EPISODES)
    assert export_lerobot(data, tmp_path / "l", EXPERT, failed=False) == 2
    frames = parquet.read_table(tmp_path / "l/data/chunk-000/file-000.parquet").to_pydict()
    states = np.concatenate([EPISODES[0].states, EPISODES[2].states]).astype(np.float32)
    acted = np.concatenate([EPISODES[0].acted, EPISODES[2].acted])
    np.testing.assert_array_equal(np.array(frames["observation.state"], np.float32), states)
    np.testing.assert_array_equal(np.array(frames["action"], np.float32), acted)
    assert frames["index"] == list(range(17))
    assert frames["episode_index"] == [0] * 12 + [1] * 5
    assert frames["frame_index"] == [*range(12), *range(5)]
    np.testing.assert_allclose(frames["timestamp"], np.array(frames["frame_index"]) / 20, rtol=1e-6)
    told = parquet.read_table(tmp_path / "l/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [(one["dataset_from_index"], one["dataset_to_index"]) for one in told] == [
        (0, 12),
        (12, 17),
    ]
    info = json.loads((tmp_path / "l/meta/info.json").read_text())
    assert (info["total_frames"], info["total_episodes"], info["fps"]) == (17, 2, 20)
    assert info["features"]["action"]["names"][6] == "gripper_position[0]"
    stats = json.loads((tmp_path / "l/meta/stats.json").read_text())
    np.testing.assert_allclose(stats["action"]["mean"], acted.astype(float).mean(0))


def test_another_manifest_than_the_recorded_one_names_nothing(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "d", *EPISODES)
    changed = EXPERT.model_copy(update={"horizon": EXPERT.horizon + 1})
    with pytest.raises(ConfigError, match="expected the manifest that was recorded, SHA-256 "):
        export_lerobot(data, tmp_path / "l", changed, failed=False)
    assert not (tmp_path / "l").exists()


@pytest.mark.parametrize(
    ("name", "edited"), [("prompt", "sing"), ("rate_hz", 21.0), ("pictures", ["eye"])]
)
def test_a_description_that_was_edited_is_refused(
    name: str, edited: object, tmp_path: Path
) -> None:
    file = drawn_dataset(tmp_path / "d", *EPISODES) / FILE
    told = json.loads(file.read_text())
    assert told[name] != edited
    file.write_text(json.dumps(told | {name: edited}))
    with pytest.raises(ConfigError, match=f"{FILE}: {name}: expected .*, as in that manifest, got"):
        export_lerobot(tmp_path / "d", tmp_path / "l", EXPERT, failed=False)
    assert not (tmp_path / "l").exists()


def test_nothing_is_left_of_an_export_that_ctrl_c_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = drawn_dataset(tmp_path / "d", *EPISODES)

    def interrupted(table: object, path: Path) -> None:
        path.write_bytes(b"half of it")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(parquet, "write_table", interrupted)
        with pytest.raises(KeyboardInterrupt):
            export_lerobot(data, tmp_path / "l", EXPERT, failed=False)
    assert export_lerobot(data, tmp_path / "l", EXPERT, failed=False) == 2


def test_failures_are_written_only_if_asked_for(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "d", *EPISODES)
    assert export_lerobot(data, tmp_path / "l", EXPERT, failed=True) == 3
    only_failed = drawn_dataset(tmp_path / "f", EPISODES[1])
    with pytest.raises(ConfigError, match="expected an episode that succeeded"):
        export_lerobot(only_failed, tmp_path / "m", EXPERT, failed=False)
    assert not (tmp_path / "m").exists()


def test_pictures_are_in_the_frames_to_the_last_pixel_with_statistics_of_each_colour(
    tmp_path: Path,
) -> None:
    data, name = drawn_pictures(tmp_path / "d", 3, 4), "observation.images.eye"
    assert export_lerobot(data, tmp_path / "l", CLONE, failed=False) == 2
    frames = parquet.read_table(tmp_path / "l/data/chunk-000/file-000.parquet").to_pydict()[name]
    pixels = np.array([np.asarray(Image.open(io.BytesIO(one["bytes"]))) for one in frames])
    recorded = np.concatenate([drawn_sight(seed).pictures["eye"] for seed in (3, 4)])
    np.testing.assert_array_equal(pixels, recorded)
    info = json.loads((tmp_path / "l/meta/info.json").read_text())
    assert info["features"][name]["dtype"] == "image"
    assert info["features"][name]["shape"] == [64, 64, 3]
    stats = json.loads((tmp_path / "l/meta/stats.json").read_text())[name]
    shares = recorded / 255
    assert stats["count"] == [80]
    for key in ("min", "max", "mean", "std"):
        wanted = getattr(shares, key)((0, 1, 2)).reshape(3, 1, 1)
        np.testing.assert_allclose(stats[key], wanted, rtol=1e-12)
    wanted = np.quantile(shares, 0.9, axis=(0, 1, 2), method="inverted_cdf").reshape(3, 1, 1)
    np.testing.assert_allclose(stats["q90"], wanted)
