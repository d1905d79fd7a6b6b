"""A folder of recorded episodes: ``dataset.json``, and one ``episode_<seed>.npz`` each.

Numbers of one episode, a row for each control period: ``states`` float64 ``[T, n]``, the layout
vector that the policy would be given; ``rows`` float32 ``[T, dim]``, what the policy said for it;
``acted`` float32 ``[T, dim]``, what the robot was given, after the slots' clips and thresholds and
the noise that was asked for. Of a deployed episode also ``released`` bool ``[T]``: whether the
gate released the row of that tick and all the skill's parts did it; where not, ``acted`` is what
the robot was given to hold, and ``rows`` NaN where no answer reached that tick. Of a skill that
sees pictures also, with the name of each,
``picture_<name>`` uint8 ``[T, height, width, 3]``, RGB, after the skill's transforms. Where an
expert was asked, ``labels`` float32 ``[T, H, dim]``, its answer in each of those states.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any
from zipfile import BadZipFile

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.paths import written
from fairlead.regular_file import regular
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.episode_arrays import PICTURE, TICKS, check_array, sizes_of

FILE = "dataset.json"
_ARRAYS = ("states", "rows", "acted")
_UNREADABLE = (
    OSError, EOFError, KeyError, TypeError, ValueError, RuntimeError, MemoryError, BadZipFile,
    zlib.error,
)  # fmt: skip
NO_LABELS: npt.NDArray[np.float32] = np.zeros((0, 0, 0), np.float32)
NO_GATE: npt.NDArray[np.bool_] = np.zeros(0, np.bool_)


@dataclass(frozen=True)
class Episode:
    """One episode, as above; succeeded: what the simulator's task said at its end."""

    seed: int
    succeeded: bool
    states: FloatArray
    rows: npt.NDArray[np.float32]
    acted: npt.NDArray[np.float32]
    pictures: Mapping[str, npt.NDArray[np.uint8]] = field(default_factory=dict)
    labels: npt.NDArray[np.float32] = field(default_factory=NO_LABELS.copy)
    released: npt.NDArray[np.bool_] = field(default_factory=NO_GATE.copy)


class Told(msgspec.Struct, frozen=True):
    """One episode as `FILE` lists it; released: ticks whose row was, None without a gate."""

    seed: int
    ticks: Annotated[int, msgspec.Meta(ge=1)]
    succeeded: bool
    released: int | None = None


class Header(msgspec.Struct, frozen=True):
    """What was recorded.

    skill_hash: SHA-256 of the skill's manifest, in hexadecimal digits. noise: largest standard
    deviation of what was added to a number of a row, as a share of its full scale.
    expert: that was asked; "" for none.
    pictures: their names. deployed: through the services, and judged by the gate.
    meaning: what the skill's manifest said of all these numbers, as `meaning` has it.
    """

    skill: str
    skill_hash: str
    robot: str
    layout: str
    prompt: str
    rate_hz: Annotated[float, msgspec.Meta(gt=0)]
    noise: float
    expert: str = ""
    pictures: tuple[str, ...] = ()
    deployed: bool = False
    episodes: tuple[Told, ...] = ()
    meaning: dict[str, Any] = {}


def begin(
    folder: Path,
    skill: SkillManifest,
    robot: str,
    noise: float,
    expert: str = "",
    *,
    deployed: bool = False,
) -> Header:
    """A new dataset without episodes.

    Raises:
        ConfigError: the folder holds something else than a dataset without episodes.
    """
    held = {path.name for path in folder.iterdir()} if folder.exists() else set[str]()
    if held - {FILE} or (held and read_header(folder).episodes):
        raise ConfigError(expected("dataset", "a folder that is new or empty", folder))
    folder.mkdir(parents=True, exist_ok=True)
    header = Header(
        skill.id, skill.skill_hash.hex(), robot, skill.state_contract.layout_name, skill.prompt,
        skill.rate_hz, noise, expert, tuple(skill.images), deployed, meaning=meaning(skill),
    )  # fmt: skip
    _write(folder, header)
    return header


def add(folder: Path, header: Header, episode: Episode) -> Header:
    """Append one; what the folder holds is whole after each.

    Raises:
        ConfigError: another program writes to the folder too.
    """
    if read_header(folder) != header:
        got = "what another recording wrote; give each a folder of its own"
        raise ConfigError(expected(f"dataset {folder}", "nobody else to record into it", got))
    arrays = {name: getattr(episode, name) for name in _names(header)}
    arrays |= {PICTURE + name: frames for name, frames in episode.pictures.items()}
    save = np.savez_compressed if episode.pictures else np.savez
    path = _path(folder, episode.seed)
    with written(path, path):
        save(path, **arrays)
    released = int(episode.released.sum()) if header.deployed else None
    told = Told(episode.seed, len(episode.states), episode.succeeded, released)
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
        return msgspec.json.decode(regular(path).read_bytes(), type=Header)
    except OSError as error:
        raise ConfigError(
            f"dataset: {path}: cannot be read: {error.strerror}; make a dataset with: "
            "fairlead dataset record SKILL"
        ) from None
    except msgspec.ValidationError as error:
        raise ConfigError(f"dataset: {path}: {error}") from None
    except (ValueError, RecursionError) as error:  # msgspec's own errors are ValueErrors
        raise ConfigError(expected(f"dataset: {path}", "JSON", f"none: {error}")) from None


def episodes(folder: Path, skill: SkillManifest | None = None) -> Iterator[Episode]:
    """Every episode, in the order they were recorded.

    Args:
        skill: whose numbers they must be; None: all episodes have as many as the first.

    Raises:
        ConfigError: a file is missing, or not what `FILE` says.
    """
    header = read_header(folder)
    names = [*_names(header), *(PICTURE + name for name in header.pictures)]
    sizes = {} if skill is None else sizes_of(skill)
    for told in header.episodes:
        path = _path(folder, told.seed)
        try:
            with regular(path).open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                arrays = {name: file[name] for name in names}
        except _UNREADABLE as error:
            why = getattr(error, "strerror", None) or error
            raise ConfigError(expected(f"dataset: {path}", "an episode", f"none: {why}")) from None
        sizes[TICKS] = told.ticks
        for name, array in arrays.items():
            may_lack = header.deployed and name == "rows"
            check_array(f"dataset: {path}: {name}", name, array, sizes, may_lack)
        pictures = {name: arrays.pop(PICTURE + name) for name in header.pictures}
        yield Episode(told.seed, told.succeeded, **arrays, pictures=pictures)


def every_episode(folders: Sequence[Path], skill: SkillManifest) -> list[Episode]:
    """Those of several datasets, to learn from; raises as `episodes`, and if there are none."""
    found = [one for folder in folders for one in episodes(folder, skill)]
    if not found:
        where = ", ".join(map(str, folders))
        told = expected("train", f"episodes in {where}", "none; see: fairlead dataset show")
        raise ConfigError(told)
    return found


def same_kind(folders: Sequence[Path]) -> Header:
    """What several datasets have in common, what a policy sees and who taught; the first's header.

    Raises:
        ConfigError: they differ.
    """
    headers = [read_header(folder) for folder in folders]
    for folder, one in zip(folders, headers, strict=True):
        wanted, got = (
            (h.robot, h.layout, h.rate_hz, h.pictures, h.expert) for h in (headers[0], one)
        )
        if got != wanted:
            raise ConfigError(expected(f"dataset {folder}", f"one of {wanted}", got))
        _require_meaning(folder, one, f"dataset {folders[0]}", headers[0].meaning)
    return headers[0]


def require_skill(folder: Path, skill: SkillManifest) -> None:
    """That a dataset's numbers are those of the skill as it is now.

    Raises:
        ConfigError: with all that differs.
    """
    _require_meaning(folder, read_header(folder), f"skill {skill.id}", meaning(skill))


def _require_meaning(folder: Path, header: Header, who: str, wanted: dict[str, Any]) -> None:
    if not header.meaning:
        what = "one that says what its numbers mean"
        raise ConfigError(expected(f"dataset {folder}", what, "an older one; record it again"))
    problems = list(differences(wanted, header.meaning))
    if problems:
        listed = "".join(f"\n  {one}" for one in problems)
        raise ConfigError(f"dataset {folder}: its numbers mean others than those of {who}:{listed}")


def _names(header: Header) -> tuple[str, ...]:
    labels, released = ("labels",) * bool(header.expert), ("released",) * header.deployed
    return (*_ARRAYS, *labels, *released)


def _path(folder: Path, seed: int) -> Path:
    return folder / f"episode_{seed:06d}.npz"


def _write(folder: Path, header: Header) -> None:
    text = json.dumps(msgspec.to_builtins(header), indent=1) + "\n"
    unfinished = folder / f"{FILE}.new"
    with written(folder / FILE, unfinished):
        unfinished.write_text(text, encoding="utf-8")
        unfinished.replace(folder / FILE)


_OF_A_NETWORK = {"clip", "threshold"}  # a clone has others than its expert
_IN_SI = {"unit", "scale", "offset"}


def meaning(skill: SkillManifest) -> dict[str, Any]:
    """State, pictures, rows of a call and routed slots, for JSON; defaults are left out."""
    slots = sorted(skill.action_contract.routed, key=lambda slot: slot.first)
    return {
        "state_contract": skill.state_contract.model_dump(mode="json", exclude_defaults=True),
        "images": {
            name: spec.model_dump(mode="json", exclude_defaults=True, exclude={"contrast_min"})
            for name, spec in skill.images.items()
        },
        "horizon": skill.horizon,
        "slots": [
            slot.model_dump(mode="json", exclude_defaults=True, exclude=_OF_A_NETWORK | _IN_SI)
            | {"scale": list(slot.scales()), "offset": list(slot.offsets())}
            for slot in slots
        ],
    }


def differences(wanted: Any, got: Any, where: str = "") -> Iterator[str]:
    """Where two of them differ, in words."""
    if isinstance(wanted, dict) and isinstance(got, dict):
        for key in sorted({*wanted, *got}):
            below = f"{where}.{key}" if where else key
            yield from differences(wanted.get(key, "nothing"), got.get(key, "nothing"), below)
    elif isinstance(wanted, list) and isinstance(got, list) and len(wanted) == len(got):
        for index, (one, other) in enumerate(zip(wanted, got, strict=True)):
            yield from differences(one, other, f"{where}.{index}")
    elif wanted != got:
        yield expected(where, wanted, got)
