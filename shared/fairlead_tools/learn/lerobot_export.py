"""A dataset as a LeRobotDataset, format v3.0: what `lerobot.datasets.LeRobotDataset` opens.

One parquet file of frames, one of episodes, one of tasks, ``info.json`` and ``stats.json``.
Pictures are PNG in the file of frames: nothing of a pixel is lost.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.dataset import FILE, Episode, Header, episodes, read_header
from fairlead_tools.writable import not_written, require_writable

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = "v3.0"
_PARQUET = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_FIRST = _PARQUET.format(chunk_index=0, file_index=0)
_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_SCALARS = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
Columns = dict[str, npt.NDArray[Any]]
_LEVELS = np.arange(256) / 255


@dataclass(frozen=True)
class _Pictures:
    """One column of them. shape: of each. counts: int64 ``[3, 256]``, pixels of each level."""

    shape: tuple[int, ...]
    files: list[bytes]
    counts: npt.NDArray[np.int64]


@dataclass(frozen=True)
class _Part:
    """One episode's columns."""

    columns: Columns
    pictures: dict[str, _Pictures]


def export_lerobot(folder: Path, target: Path, skill: SkillManifest, failed: bool) -> int:
    """Write the episodes that succeeded; actions are what acted. Returns how many.

    Of deployed episodes the column ``released`` says where that is a hold, no row of the policy's.

    Args:
        skill: that was recorded; names its numbers.
        failed: write the others too.

    Raises:
        ConfigError: no episode is left, another skill was recorded, the folder holds something,
            pyarrow is not installed, or the disk does not take it: nothing is left then.
    """
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise ConfigError(
            "export lerobot: the package pyarrow is not installed: pip install 'fairlead[dataset]'"
        ) from None
    header = read_header(folder)
    _check(folder, header, target, skill)
    parts: list[_Part] = []
    for episode in episodes(folder, skill):
        if episode.succeeded or failed:
            before = sum(len(part.columns["index"]) for part in parts)
            columns = _columns(episode, len(parts), before, header.rate_hz)
            parts.append(_Part(columns, _pictures(episode)))
    if not parts:
        raise ConfigError(expected("export lerobot", "an episode that succeeded", "none: --failed"))
    whole = _Part(
        {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns},
        {name: _joined([part.pictures[name] for part in parts]) for name in parts[0].pictures},
    )
    tables = {
        f"data/{_FIRST}": _table(whole, pa),
        f"meta/episodes/{_FIRST}": pa.Table.from_pylist(
            [_told(part, header.prompt) for part in parts]
        ),
        "meta/tasks.parquet": _tasks(header.prompt, pa),
    }
    documents = {
        "info.json": _info(whole, header.robot, header.rate_hz, len(parts), skill),
        "stats.json": _statistics(whole),
    }
    with _whole_or_nothing(target):
        for name, table in tables.items():
            path = target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            parquet.write_table(table, path)
        for name, document in documents.items():
            (target / "meta" / name).write_text(json.dumps(document, indent=4), encoding="utf-8")
    return len(parts)


@contextmanager
def _whole_or_nothing(target: Path) -> Iterator[None]:
    """No half of an export is left, nor is in the way of the next one.

    Raises:
        ConfigError: the disk does not take it.
    """
    try:
        yield
    except BaseException as error:  # Ctrl-C too
        for name in ("data", "meta"):
            shutil.rmtree(target / name, ignore_errors=True)
        if isinstance(error, OSError):
            raise not_written("export lerobot", target, error) from None
        raise


def _check(folder: Path, header: Header, target: Path, skill: SkillManifest) -> None:
    """That the skill is the recorded one, and that there is room for the export."""
    if header.skill_hash != skill.skill_hash.hex():
        who, what = f"export lerobot: skill {skill.id}", "the manifest that was recorded, SHA-256 "
        raise ConfigError(expected(who, what + header.skill_hash, skill.skill_hash.hex()))
    recorded = {"prompt": skill.prompt, "rate_hz": skill.rate_hz, "pictures": tuple(skill.images)}
    for name, one in recorded.items():
        if (got := getattr(header, name)) != one:
            who = f"export lerobot: {folder / FILE}: {name}"
            raise ConfigError(expected(who, f"{one!r}, as in that manifest", repr(got)))
    if target.exists() and any(target.iterdir()):
        raise ConfigError(expected("export lerobot", "a folder that is new or empty", target))
    require_writable("export lerobot", target)


def _columns(episode: Episode, index: int, before: int, rate_hz: float) -> Columns:
    frames = np.arange(len(episode.states))
    return {
        "observation.state": episode.states.astype(np.float32),
        "action": episode.acted,
        **({"released": episode.released} if len(episode.released) else {}),
        "timestamp": (frames / rate_hz).astype(np.float32),
        "frame_index": frames,
        "episode_index": np.full(len(frames), index),
        "index": frames + before,
        "task_index": np.zeros(len(frames), np.int64),
    }


def _pictures(episode: Episode) -> dict[str, _Pictures]:
    return {
        f"observation.images.{name}": _Pictures(
            frames.shape[1:],
            [_png(frame) for frame in frames],
            np.array([np.bincount(frames[..., one].ravel(), minlength=256) for one in range(3)]),
        )
        for name, frames in episode.pictures.items()
    }


def _joined(parts: list[_Pictures]) -> _Pictures:
    files = [file for part in parts for file in part.files]
    return _Pictures(parts[0].shape, files, np.sum([part.counts for part in parts], axis=0))


def _png(pixels: npt.NDArray[np.uint8]) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "png")
    return stream.getvalue()


def _table(part: _Part, arrow: Any) -> pa.Table:
    arrays = {
        name: arrow.FixedSizeListArray.from_arrays(arrow.array(values.ravel()), values.shape[1])
        if values.ndim > 1
        else arrow.array(values)
        for name, values in part.columns.items()
    }
    kind = arrow.struct({"bytes": arrow.binary(), "path": arrow.string()})
    for name, pictures in part.pictures.items():
        arrays[name] = arrow.array([{"bytes": one, "path": None} for one in pictures.files], kind)
    return arrow.table(arrays)


def _told(part: _Part, task: str) -> dict[str, Any]:
    """A row of the episodes' table."""
    first, length = int(part.columns["index"][0]), len(part.columns["index"])
    row: dict[str, Any] = {
        "episode_index": int(part.columns["episode_index"][0]), "tasks": [task], "length": length,
        "data/chunk_index": 0, "data/file_index": 0,
        "dataset_from_index": first, "dataset_to_index": first + length,
        "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
    }  # fmt: skip
    for name, found in _statistics(part).items():
        row |= {f"stats/{name}/{key}": value for key, value in found.items()}
    return row


def _tasks(task: str, arrow: Any) -> pa.Table:
    """As pandas writes a table whose index is the tasks' text."""
    described = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [
            {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_kind,
             "metadata": None}
            for name, kind, numpy_kind in (("task_index", "int64", "int64"),
                                           ("task", "unicode", "object"))
        ],
    }  # fmt: skip
    table = arrow.table({"task_index": arrow.array([0], arrow.int64()), "task": [task]})
    return table.replace_schema_metadata({"pandas": json.dumps(described)})


def _statistics(part: _Part) -> dict[str, dict[str, Any]]:
    return {name: _of_numbers(values) for name, values in part.columns.items()} | {
        name: _of_pictures(pictures) for name, pictures in part.pictures.items()
    }


def _of_numbers(values: npt.NDArray[Any]) -> dict[str, Any]:
    rows = values.reshape(len(values), -1).astype(np.float64)
    found = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0)}
    found |= {name: np.quantile(rows, share, axis=0) for name, share in _QUANTILES.items()}
    return {name: one.tolist() for name, one in found.items()} | {"count": [len(rows)]}


def _of_pictures(pictures: _Pictures) -> dict[str, Any]:
    """Of each colour, from 0 to 1; lerobot wants them as pictures of one pixel."""
    shares = pictures.counts / pictures.counts.sum(1, keepdims=True)
    mean, below = shares @ _LEVELS, shares.cumsum(1)
    found = {
        "min": _LEVELS[(pictures.counts > 0).argmax(1)],
        "max": _LEVELS[255 - (pictures.counts[:, ::-1] > 0).argmax(1)],
        "mean": mean,
        "std": np.sqrt((shares * (_LEVELS - mean[:, None]) ** 2).sum(1)),
    } | {name: _LEVELS[(below >= share).argmax(1)] for name, share in _QUANTILES.items()}
    pixels = {name: one.reshape(3, 1, 1).tolist() for name, one in found.items()}
    return pixels | {"count": [len(pictures.files)]}


def _info(
    whole: _Part, robot: str, rate_hz: float, count: int, skill: SkillManifest
) -> dict[str, Any]:
    from fairlead_skill_runner import action_names, state_names

    names = {"observation.state": state_names(skill), "action": action_names(skill)}
    features: dict[str, Any] = {
        name: {"dtype": "float32", "shape": [len(one)], "names": list(one)}
        for name, one in names.items()
    }
    features |= {
        name: {"dtype": "image", "shape": list(one.shape), "names": ["height", "width", "channels"]}
        for name, one in whole.pictures.items()
    }
    scalars = _SCALARS | ({"released": "bool"} if "released" in whole.columns else {})
    features |= {
        name: {"dtype": kind, "shape": [1], "names": None} for name, kind in scalars.items()
    }
    return {
        "codebase_version": VERSION, "robot_type": robot, "total_episodes": count,
        "total_frames": len(whole.columns["index"]), "total_tasks": 1, "chunks_size": 1000,
        "data_files_size_in_mb": 100, "video_files_size_in_mb": 200,
        "fps": int(rate_hz) if rate_hz == int(rate_hz) else rate_hz,
        "splits": {"train": f"0:{count}"}, "data_path": f"data/{_PARQUET}", "video_path": None,
        "features": features,
    }  # fmt: skip
