"""Datasets: what is written is read again, and what is none is said to be none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead_tools.learn.dataset import add, begin, episodes, read_header, same_kind
from tests.learn.drawn import EXPERT, drawn_dataset, drawn_episode


def test_episodes_come_back_bit_for_bit_in_their_order(tmp_path: Path) -> None:
    written = [drawn_episode(7), drawn_episode(3, 5, succeeded=False)]
    folder = drawn_dataset(tmp_path / "d", *written)
    header = read_header(folder)
    assert [(one.seed, one.ticks, one.succeeded) for one in header.episodes] == [
        (7, 12, True),
        (3, 5, False),
    ]
    assert header.skill_hash == EXPERT.skill_hash.hex()
    for one, back in zip(written, episodes(folder), strict=True):
        for name in ("states", "rows", "acted"):
            assert getattr(back, name).tobytes() == getattr(one, name).tobytes()
            assert getattr(back, name).dtype == getattr(one, name).dtype


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(ConfigError, match="expected a folder that is new or empty"):
        begin(tmp_path, EXPERT, "panda_mobile", 0.0)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_dataset_without_episodes_is_begun_again(tmp_path: Path) -> None:
    begin(tmp_path, EXPERT, "panda_mobile", 0.0)
    header = begin(tmp_path, EXPERT, "panda_mobile", 0.5)
    assert read_header(tmp_path) == header and header.noise == 0.5
    add(tmp_path, header, drawn_episode(1))
    with pytest.raises(ConfigError, match="expected a folder that is new or empty"):
        begin(tmp_path, EXPERT, "panda_mobile", 0.0)


@pytest.mark.parametrize("damage", ["none", "json", "missing", "cut", "empty", "short", "pickle"])
def test_what_is_no_dataset_is_one_error_with_the_file(tmp_path: Path, damage: str) -> None:
    folder = drawn_dataset(tmp_path / "d", drawn_episode(7))
    header, file = folder / "dataset.json", folder / "episode_000007.npz"
    if damage == "none":
        header.unlink()
    elif damage == "json":
        header.write_text("{")
    elif damage == "missing":
        file.unlink()
    elif damage == "cut":
        file.write_bytes(file.read_bytes()[:100])
    elif damage == "empty":
        file.write_bytes(b"")
    elif damage == "short":
        one = drawn_episode(7, 4)
        np.savez(file, states=one.states, rows=one.rows, acted=one.acted)
    else:
        np.savez(file, states=np.array([{}]), rows=np.zeros(1), acted=np.zeros(1))
    with pytest.raises(ConfigError) as caught:
        list(episodes(folder))
    assert str(header if damage in ("none", "json") else file) in str(caught.value)


def test_datasets_of_different_layouts_do_not_go_together(tmp_path: Path) -> None:
    one, other = (drawn_dataset(tmp_path / name, drawn_episode(1)) for name in "ab")
    text = (other / "dataset.json").read_text().replace("mobile_pick_30d", "libero")
    (other / "dataset.json").write_text(text)
    assert same_kind([one, one]).layout == "mobile_pick_30d"
    with pytest.raises(ConfigError, match="dataset .*b: expected one of .* got .*libero"):
        same_kind([one, other])
