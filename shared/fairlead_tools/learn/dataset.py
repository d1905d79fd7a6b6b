"""A folder of recorded episodes: ``dataset.json``, and one ``episode_<seed>.npz`` each.

Numbers of one episode, a row for each control period: ``states`` float64 ``[T, n]``, the layout
vector that the policy would be given; ``rows`` float32 ``[T, dim]``, what the policy said for it;
``acted`` float32 ``[T, dim]``, what the robot was given, after the slots' clips and thresholds and
the noise that was asked for.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.skill.manifest import SkillManifest

FILE = "dataset.json"
_ARRAYS = ("states", "rows", "acted")


@dataclass(frozen=True)
class Episode:
    """One episode, as above; succeeded: what the simulator's task said at its end."""

    seed: int
    succeeded: bool
    states: FloatArray
    rows: npt.NDArray[np.float32]
    acted: npt.NDArray[np.float32]


class Told(msgspec.Struct, frozen=True):
    """One episode as `FILE` lists it."""

    seed: int
    ticks: int
    succeeded: bool


class Header(msgspec.Struct, frozen=True):
    """What was recorded.

    skill_hash: SHA-256 of the skill's manifest, in hexadecimal digits. noise: most that was added
    to a number of a row, as a share of its full scale.
    """

    skill: str
    skill_hash: str
    robot: str
    layout: str
    prompt: str
    rate_hz: float
    noise: float
    episodes: tuple[Told, ...] = ()


def begin(folder: Path, skill: SkillManifest, robot: str, noise: float) -> Header:
    """A new dataset without episodes.

    Raises:
        ConfigError: the folder holds something.
    """
    if folder.exists() and any(folder.iterdir()):
        raise ConfigError(expected("dataset", "a folder that is new or empty", folder))
    folder.mkdir(parents=True, exist_ok=True)
    header = Header(
        skill.id, skill.skill_hash.hex(), robot, skill.state_contract.layout_name, skill.prompt,
        skill.rate_hz, noise,
    )  # fmt: skip
    _write(folder, header)
    return header


def add(folder: Path, header: Header, episode: Episode) -> Header:
    """Append one; what the folder holds is whole after each."""
    np.savez(
        _path(folder, episode.seed), states=episode.states, rows=episode.rows, acted=episode.acted
    )
    told = Told(episode.seed, len(episode.states), episode.succeeded)
    header = msgspec.structs.replace(header, episodes=(*header.episodes, told))
    _write(folder, header)
    return header


def read_header(folder: Path) -> Header:
    """What a dataset says of itself.

    Raises:
        ConfigError: it is none.
    """
    path = folder / FILE
    try:
        return msgspec.json.decode(path.read_bytes(), type=Header)
    except OSError as error:
        raise ConfigError(
            f"dataset {folder}: no dataset: {path}: {error.strerror}; make one with: "
            "fairlead dataset record SKILL"
        ) from None
    except msgspec.DecodeError as error:
        raise ConfigError(f"dataset: {path}: {error}") from None


def episodes(folder: Path) -> Iterator[Episode]:
    """Every episode, in the order they were recorded.

    Raises:
        ConfigError: a file is missing, or not what `FILE` says.
    """
    for told in read_header(folder).episodes:
        path = _path(folder, told.seed)
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                arrays = [file[name] for name in _ARRAYS]
        except (OSError, KeyError, ValueError, BadZipFile) as error:
            raise ConfigError(f"dataset: {path}: no episode: {error}") from None
        if {len(array) for array in arrays} != {told.ticks}:
            lengths = [len(array) for array in arrays]
            raise ConfigError(expected(f"dataset: {path}", f"{told.ticks} ticks", lengths))
        yield Episode(told.seed, told.succeeded, *arrays)


def same_kind(folders: Sequence[Path]) -> Header:
    """What several datasets have in common: robot, layout and rate; the first one's header.

    Raises:
        ConfigError: they differ.
    """
    headers = [read_header(folder) for folder in folders]
    for folder, one in zip(folders, headers, strict=True):
        wanted, got = ((h.robot, h.layout, h.rate_hz) for h in (headers[0], one))
        if got != wanted:
            raise ConfigError(expected(f"dataset {folder}", f"one of {wanted}", got))
    return headers[0]


def _path(folder: Path, seed: int) -> Path:
    return folder / f"episode_{seed:06d}.npz"


def _write(folder: Path, header: Header) -> None:
    text = json.dumps(msgspec.to_builtins(header), indent=1) + "\n"
    (folder / FILE).write_text(text, encoding="utf-8")
