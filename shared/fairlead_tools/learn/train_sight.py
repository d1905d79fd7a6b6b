"""From recorded episodes with a picture to a skill that sees: what the expert said of each tick.

The same datasets, recipe and libraries give the same file, byte for byte, on one machine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_tools.learn.dataset import Header, every_episode, require_skill, same_kind
from fairlead_tools.learn.sight import fit_pictures, forward, sight_onnx
from fairlead_tools.learn.train import (
    LEAST_STD,
    block,
    dataset_told,
    require_new,
    split,
    write_skill,
)


@dataclass(frozen=True)
class SightRecipe:
    """How to train."""

    seed: int = 0
    epochs: int = 30


def train_sight(
    folders: Sequence[Path], recipe: SightRecipe, target: Path, say: Callable[[str], None]
) -> None:
    """Write the skill ``target``: the manifest of the recorded one, but for the policy.

    Raises:
        ConfigError: datasets that differ, whose manifest has changed since, without an expert's
            labels, with several pictures or one that is not square; a target that is there; jax,
            optax or onnx not installed.
    """
    header = same_kind(folders)
    require_new(target)
    skill = load_skill(header.skill)
    require_skill(folders[0], skill)
    name = _picture(header, skill)
    libraries = _libraries()
    found = every_episode(folders, skill)
    pictures = np.concatenate([one.pictures[name] for one in found])
    states = np.concatenate([one.states for one in found])
    labels = np.concatenate([one.labels for one in found]).astype(np.float64)
    say(f"{len(found)} episodes, {len(labels)} labels of {header.expert}")
    model, statistics, error = _network(skill, name, pictures, states, labels, recipe, say)
    told = {
        "recipe": asdict(recipe), "expert": header.expert, "libraries": libraries,
        "datasets": [dataset_told(folder) for folder in folders],
        "labels": len(labels), "left_out_ticks_error": error,
    }  # fmt: skip
    document = skill.model_dump(mode="json", exclude_defaults=True)
    write_skill(target, document, model, statistics, told)
    missed = f"squared error in ticks left out of its episodes: {error:.4f} of a variance"
    say(f"{target}: {len(model) // 1024} KiB; {missed}")


def _network(
    skill: SkillManifest,
    name: str,
    pictures: npt.NDArray[np.uint8],
    states: FloatArray,
    labels: FloatArray,
    recipe: SightRecipe,
    say: Callable[[str], None],
) -> tuple[bytes, dict[str, Any], float]:
    from fairlead_skill_runner import action_names, as_declared, state_names

    count, horizon, dim = labels.shape
    centre, spread = states.mean(0), states.std(0) + LEAST_STD
    mean, std = labels.mean((0, 1)), labels.std((0, 1))
    std[std < LEAST_STD] = 0.0
    moving = np.tile(std > 0, horizon)
    inputs = ((states - centre) / spread).astype(np.float32)
    outputs = ((labels - mean) / np.where(std > 0, std, 1.0)).reshape(count, -1)
    outputs = np.where(moving, outputs, 0.0).astype(np.float32)
    apart, used = split(count, recipe.seed)
    given = partial(as_declared, skill.images[name])
    weights = fit_pictures(
        pictures[used], given, inputs[used], outputs[used], recipe.seed, recipe.epochs, say
    )
    missed = np.asarray(forward(weights, given(pictures[apart]), inputs[apart])) - outputs[apart]
    error = float((missed[:, moving].astype(np.float64) ** 2).mean())
    statistics = {
        "observation.state": block(state_names(skill), centre, spread),
        "action": block(action_names(skill), mean, std),
    }
    return sight_onnx(weights, name, pictures.shape[1], horizon, dim), statistics, error


def _picture(header: Header, skill: SkillManifest) -> str:
    """The name of the one picture.

    Raises:
        ConfigError: there are several, it is not square, or nobody said what to do.
    """
    who = f"train: dataset of {header.skill}"
    if not header.expert:
        raise ConfigError(expected(who, "labels of an expert", "none: dataset record --expert"))
    name, fits = header.pictures[0], False
    if len(header.pictures) == 1 and name in skill.images:
        spec = skill.images[name]
        square = spec.axes == "chw" and spec.shape[1] == spec.shape[2]
        fits = square and spec.dtype == "float32_unit" and len(spec.deltas) == 1
    if not fits:
        got = {name: (one.shape, one.dtype, one.deltas) for name, one in skill.images.items()}
        wanted = "one picture, square, of now, axes chw, dtype float32_unit"
        raise ConfigError(expected(who, wanted, got))
    return name


def _libraries() -> dict[str, Any]:
    try:
        import jax
        import onnx
        import optax
    except ImportError as error:
        raise ConfigError(f"train: {error}: pip install 'fairlead[train-pictures]'") from None
    return {one.__name__: one.__version__ for one in (np, jax, optax, onnx)}
