"""A dataset as a LeRobotDataset, format v3.0: what `lerobot.datasets.LeRobotDataset` opens.

One parquet file of frames, one of episodes, one of tasks, ``info.json`` and ``stats.json``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.dataset import Episode, episodes, read_header

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = "v3.0"
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_FIRST = _FILE.format(chunk_index=0, file_index=0)
_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_SCALARS = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
Columns = dict[str, npt.NDArray[Any]]


def export_lerobot(folder: Path, target: Path, skill: SkillManifest, failed: bool) -> int:
    """Write the episodes that succeeded; actions are what acted. Returns how many.

    Args:
        skill: that was recorded; names its numbers.
        failed: write the others too.

    Raises:
        ConfigError: no episode is left, it has pictures, the folder holds something, pyarrow is not
            installed.
    """
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise ConfigError(
            "export lerobot: the package pyarrow is not installed: pip install 'fairlead[dataset]'"
        ) from None
    header = read_header(folder)
    if header.pictures:
        got = ", ".join(header.pictures)
        raise ConfigError(expected(f"export lerobot: {folder}", "a dataset without pictures", got))
    kept = [one for one in episodes(folder) if one.succeeded or failed]
    if not kept:
        raise ConfigError(expected("export lerobot", "an episode that succeeded", "none: --failed"))
    if target.exists() and any(target.iterdir()):
        raise ConfigError(expected("export lerobot", "a folder that is new or empty", target))
    parts = []
    for index, episode in enumerate(kept):
        parts.append(_columns(episode, index, sum(len(one.states) for one in kept[:index]),
                              header.rate_hz))  # fmt: skip
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    tables = {
        f"data/{_FIRST}": _table(whole, pa),
        f"meta/episodes/{_FIRST}": pa.Table.from_pylist(
            [_told(part, header.prompt) for part in parts]
        ),
        "meta/tasks.parquet": _tasks(header.prompt, pa),
    }
    for name, table in tables.items():
        path = target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(table, path)
    documents = {
        "info.json": _info(whole, header.robot, header.rate_hz, len(kept), skill),
        "stats.json": {name: _statistics(values) for name, values in whole.items()},
    }
    for name, document in documents.items():
        (target / "meta" / name).write_text(json.dumps(document, indent=4), encoding="utf-8")
    return len(kept)


def _columns(episode: Episode, index: int, before: int, rate_hz: float) -> Columns:
    frames = np.arange(len(episode.states))
    return {
        "observation.state": episode.states.astype(np.float32),
        "action": episode.acted,
        "timestamp": (frames / rate_hz).astype(np.float32),
        "frame_index": frames,
        "episode_index": np.full(len(frames), index),
        "index": frames + before,
        "task_index": np.zeros(len(frames), np.int64),
    }


def _table(columns: Columns, arrow: Any) -> pa.Table:
    arrays = {
        name: arrow.FixedSizeListArray.from_arrays(arrow.array(values.ravel()), values.shape[1])
        if values.ndim > 1
        else arrow.array(values)
        for name, values in columns.items()
    }
    return arrow.table(arrays)


def _told(columns: Columns, task: str) -> dict[str, Any]:
    """A row of the episodes' table."""
    first, length = int(columns["index"][0]), len(columns["index"])
    row: dict[str, Any] = {
        "episode_index": int(columns["episode_index"][0]), "tasks": [task], "length": length,
        "data/chunk_index": 0, "data/file_index": 0,
        "dataset_from_index": first, "dataset_to_index": first + length,
        "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
    }  # fmt: skip
    for name, values in columns.items():
        row |= {f"stats/{name}/{key}": value for key, value in _statistics(values).items()}
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


def _statistics(values: npt.NDArray[Any]) -> dict[str, list[float]]:
    rows = values.reshape(len(values), -1).astype(np.float64)
    found = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0)}
    found |= {name: np.quantile(rows, share, axis=0) for name, share in _QUANTILES.items()}
    return {name: one.tolist() for name, one in found.items()} | {"count": [len(rows)]}


def _info(
    whole: Columns, robot: str, rate_hz: float, count: int, skill: SkillManifest
) -> dict[str, Any]:
    from fairlead_skill_runner import action_names, state_names

    names = {"observation.state": state_names(skill), "action": action_names(skill)}
    features: dict[str, Any] = {
        name: {"dtype": "float32", "shape": [len(one)], "names": list(one)}
        for name, one in names.items()
    }
    features |= {
        name: {"dtype": kind, "shape": [1], "names": None} for name, kind in _SCALARS.items()
    }
    return {
        "codebase_version": VERSION, "robot_type": robot, "total_episodes": count,
        "total_frames": len(whole["index"]), "total_tasks": 1, "chunks_size": 1000,
        "data_files_size_in_mb": 100, "video_files_size_in_mb": 200,
        "fps": int(rate_hz) if rate_hz == int(rate_hz) else rate_hz,
        "splits": {"train": f"0:{count}"}, "data_path": f"data/{_FILE}", "video_path": None,
        "features": features,
    }  # fmt: skip
