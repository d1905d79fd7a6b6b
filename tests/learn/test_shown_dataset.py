"""``fairlead dataset show`` vouches for nothing that it has not read."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.command import fairlead_here
from tests.learn.drawn import drawn_dataset, drawn_episode


def folder_instead(file: Path) -> None:
    file.unlink()
    file.mkdir()


def pipe_instead(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)


def zeros_instead(file: Path) -> None:
    file.unlink()
    file.symlink_to("/dev/zero")


def shortened(file: Path) -> None:
    os.truncate(file, file.stat().st_size // 2)


def garbled(file: Path) -> None:
    file.write_bytes(b"garbage")


def of_another_episode(file: Path) -> None:
    other = drawn_dataset(file.parent / "other", drawn_episode(7, ticks=5))
    (other / file.name).replace(file)


NO_FILE = "a pipe or a device, not a file"
NOT_THERE, FOLDER = "No such file or directory", "Is a directory"


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (Path.unlink, f"expected an episode, got none: {NOT_THERE}"),
        (folder_instead, f"expected an episode, got none: {FOLDER}"),
        (pipe_instead, f"expected an episode, got none: {NO_FILE}"),
        (zeros_instead, f"expected an episode, got none: {NO_FILE}"),
        (lambda file: os.truncate(file, 0), "expected an episode, got none: No data left in file"),
        (shortened, "expected an episode, got none: "),
        (garbled, "expected an episode, got none: "),
        (of_another_episode, "states: expected float64 [12, 30], got float64 [5, 30]"),
    ],
)
@pytest.mark.parametrize("words", [(), ("--json",)])
def test_an_episode_that_cannot_be_read_is_one_error(
    tmp_path: Path, spoil: Callable[[Path], object], said: str, words: tuple[str, ...]
) -> None:
    folder = drawn_dataset(tmp_path / "d", drawn_episode(3), drawn_episode(7))
    assert (
        "2 episodes, 24 ticks"
        in fairlead_here("dataset", "show", str(folder), state=tmp_path).stdout
    )
    file = folder / "episode_000007.npz"
    spoil(file)
    shown = fairlead_here("dataset", "show", str(folder), *words, state=tmp_path)
    assert shown.returncode == 1
    told = shown.stdout if words else shown.stderr
    assert f"dataset: {file}: {said}" in told and told.count(str(file)) == 1


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (Path.unlink, f"cannot be read: {NOT_THERE}; make a dataset with: fairlead dataset rec"),
        (folder_instead, f"cannot be read: {FOLDER}; make"),
        (pipe_instead, f"cannot be read: {NO_FILE}; make"),
        (lambda file: os.truncate(file, 0), "expected JSON, got none: Input data was truncated"),
        (garbled, "expected JSON, got none: JSON is malformed"),
    ],
)
def test_a_header_that_cannot_be_read_is_one_error(
    tmp_path: Path, spoil: Callable[[Path], object], said: str
) -> None:
    folder = drawn_dataset(tmp_path / "d", drawn_episode(3))
    file = folder / "dataset.json"
    spoil(file)
    shown = fairlead_here("dataset", "show", str(folder), state=tmp_path)
    assert (shown.returncode, shown.stdout) == (1, "")
    assert shown.stderr.startswith(f"ERROR dataset: {file}: {said}")
    assert shown.stderr.count(str(folder)) == shown.stderr.count("\n") == 1
