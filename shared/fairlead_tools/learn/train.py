"""From recorded episodes to a skill: labels of the expert, a network, its files.

The same datasets, expert, recipe and library give the same file, byte for byte, on one machine.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.dataset import (
    episodes,
    every_episode,
    read_header,
    require_skill,
    same_kind,
)
from fairlead_tools.learn.labels import Labels, label
from fairlead_tools.learn.network import features, fit, onnx_bytes
from fairlead_tools.parity.local_episode import make_policy
from fairlead_tools.writable import require_writable

LAYOUT, EXPERT = "mobile_pick_30d", "oracle"
MODEL, STATISTICS, RECIPE = "policy.onnx", "stats.json", "training.json"
LEAST_STD = 1e-3
HELD_OUT = 20  # one of so many labels measures, and trains nothing


@dataclass(frozen=True)
class Recipe:
    """How to train.

    beside: labelled states beside each second recorded one. execute_steps: of the skill that is
        made.
    """

    seed: int = 0
    beside: int = 5
    epochs: int = 60
    widths: tuple[int, ...] = (256, 256)
    execute_steps: int = 8


def train(
    folders: Sequence[Path],
    expert: SkillManifest,
    recipe: Recipe,
    target: Path,
    say: Callable[[str], None],
) -> None:
    """Write the skill ``target``: its manifest is the expert's but for the policy.

    Raises:
        ConfigError: datasets that differ, or whose numbers are not the expert's; another expert
            than the scripted one, a target that is there, scikit-learn or onnx not installed.
    """
    libraries = _libraries()
    header = same_kind(folders)
    for who, layout in (("dataset", header.layout), (expert.id, expert.state_contract.layout_name)):
        if layout != LAYOUT:
            raise ConfigError(expected(f"train: {who}", f"the layout {LAYOUT}", layout))
    if expert.policy.backend != EXPERT:
        raise ConfigError(
            expected(f"train: {expert.id}", f"the backend {EXPERT}", expert.policy.backend)
        )
    require_skill(folders[0], expert)
    require_new(target)
    policy = make_policy("train", _without_memory(expert))
    found = every_episode(folders, expert)
    say(f"{len(found)} episodes; asking {expert.id} in each state and {recipe.beside} beside it")
    labels = label(policy, found, recipe.beside, recipe.seed)
    say(f"{len(labels.states)} labels; training {recipe.epochs} epochs")
    model, statistics, error = _network(labels, recipe, expert)
    told = {
        "recipe": asdict(recipe), "expert": expert.id, "libraries": libraries,
        "datasets": [dataset_told(folder) for folder in folders],
        "labels": len(labels.states), "left_out_ticks_error": error,
    }  # fmt: skip
    write_skill(target, _fitted_slots(expert, recipe), model, statistics, told)
    missed = f"squared error in ticks left out of its episodes: {error:.4f} of a variance"
    say(f"{target}: {len(model) // 1024} KiB; {missed}")


def require_new(target: Path) -> None:
    """See that a skill can be made there.

    Raises:
        ConfigError: it is there, its name fits no skill, or the folder cannot be written.
    """
    check_name("train: --out: the skill's id", target.name)
    if (target / "rskill.yaml").exists():
        raise ConfigError(expected("train: --out", "a folder without a skill", target))
    require_writable("train: --out", target)


def write_skill(
    target: Path,
    document: dict[str, Any],
    model: bytes,
    statistics: dict[str, Any],
    told: dict[str, Any],
) -> None:
    """The skill's four files: manifest, network, statistics, and how they came about.

    Args:
        document: the manifest's, but for id and policy; ``images`` of it are the network's inputs.
    """
    target.mkdir(parents=True, exist_ok=True)
    written = json.dumps(statistics, indent=1) + "\n"
    (target / MODEL).write_bytes(model)
    (target / STATISTICS).write_text(written, encoding="utf-8")
    hashes = {MODEL: sha256(model), STATISTICS: sha256(written.encode())}
    files = [{"file": file, "sha256": digest} for file, digest in hashes.items()]
    options: dict[str, Any] = {"model": files[0], "statistics": files[1] | {"form": "mean_std"}}
    if document.get("images"):
        options["images"] = {name: name for name in document["images"]}
    made = document | {
        "id": target.name,
        "model_family": "behaviour_cloning",
        "policy": {"backend": "onnx", "options": options},
    }
    text = yaml.safe_dump(made, sort_keys=False)
    (target / "rskill.yaml").write_text(text, encoding="utf-8")
    recipe = json.dumps(told | {"sha256": hashes}, indent=1) + "\n"
    (target / RECIPE).write_text(recipe, encoding="utf-8")


def _without_memory(expert: SkillManifest) -> SkillManifest:
    """One whose answers a network can learn: the state alone decides on them."""
    options = expert.policy.options | {"memory": False}
    policy = expert.policy.model_copy(update={"options": options})
    return expert.model_copy(update={"policy": policy})


def _libraries() -> dict[str, str]:
    try:
        import onnx
        import sklearn
    except ImportError as error:
        raise ConfigError(f"train: {error}: pip install 'fairlead[train]'") from None
    return {
        "numpy": np.__version__, "scikit-learn": sklearn.__version__, "onnx": onnx.__version__
    }  # fmt: skip


def _network(
    labels: Labels, recipe: Recipe, expert: SkillManifest
) -> tuple[bytes, dict[str, Any], float]:
    from fairlead_skill_runner import action_names, state_names

    count, horizon, dim = labels.rows.shape
    rows = labels.rows.astype(np.float64)
    centre, spread = labels.states.mean(0), labels.states.std(0) + LEAST_STD
    mean, std = rows.mean((0, 1)), rows.std((0, 1))
    std[std < LEAST_STD] = 0.0
    outputs = ((rows - mean) / np.where(std > 0, std, 1.0)).reshape(count, -1)
    outputs[:, np.tile(std == 0, horizon)] = 0.0
    seen = features(centre, spread)
    inputs = seen((labels.states - centre) / spread)
    apart, used = split(count, recipe.seed)
    net = fit(inputs[used], outputs[used], recipe.seed, recipe.widths, recipe.epochs)
    moving = np.tile(std > 0, horizon)
    error = float(((net.predict(inputs[apart]) - outputs[apart])[:, moving] ** 2).mean())
    statistics = {
        "observation.state": block(state_names(expert), centre, spread),
        "action": block(action_names(expert), mean, std),
    }
    return onnx_bytes(seen, net, horizon, dim), statistics, error


def split(count: int, seed: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Indices of so many labels: those that measure, and those that train.

    Raises:
        ConfigError: there are too few.
    """
    if count < HELD_OUT:
        raise ConfigError(expected("train", f"{HELD_OUT} labels or more", count))
    order = np.random.default_rng(seed).permutation(count)
    return order[: count // HELD_OUT], order[count // HELD_OUT :]


def block(names: Sequence[str], mean: Any, std: Any) -> dict[str, Any]:
    """Of a file of statistics, one feature."""
    return {"names": list(names), "mean": mean.tolist(), "std": std.tolist()}


def _fitted_slots(expert: SkillManifest, recipe: Recipe) -> dict[str, Any]:
    """The expert's manifest with clips and thresholds: a network overshoots."""
    document = expert.model_dump(mode="json", exclude_defaults=True)
    for slot in document["action_contract"]["slots"]:
        mode = slot.get("control_mode")
        if mode in ("gripper_position", "composite_mode"):
            slot["threshold"] = 0.0
        elif mode is not None:
            slot["clip"] = [-1.0, 1.0]
    return document | {"execute_steps": recipe.execute_steps}


def dataset_told(folder: Path) -> dict[str, Any]:
    """What it is, with the SHA-256 of what is learned from it: states, pictures, labels."""
    header, digest = read_header(folder), hashlib.sha256()
    for one in episodes(folder):
        for data in (one.states.tobytes(), *map(np.ndarray.tobytes, one.pictures.values())):
            digest.update(data)
        digest.update(one.labels.tobytes())
    return {
        "skill": header.skill, "skill_hash": header.skill_hash, "noise": header.noise,
        "seeds": [one.seed for one in header.episodes],
        "succeeded": sum(one.succeeded for one in header.episodes),
        "data_sha256": digest.hexdigest(),
    }  # fmt: skip


def sha256(data: bytes) -> str:
    """In hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()
