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
import yaml

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.learn.dataset import episodes, read_header, same_kind
from fairlead_tools.learn.labels import Labels, label
from fairlead_tools.learn.network import features, fit, onnx_bytes
from fairlead_tools.parity.local_episode import make_policy

LAYOUT, EXPERT = "mobile_pick_30d", "oracle"
MODEL, STATISTICS, RECIPE = "policy.onnx", "stats.json", "training.json"
_LEAST_STD = 1e-3
_HELD_OUT = 20  # one of so many labels measures, and trains nothing


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
        ConfigError: datasets of another layout, another expert than the scripted one, a target
            that is there, scikit-learn or onnx not installed.
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
    if (target / "rskill.yaml").exists():
        raise ConfigError(expected("train: --out", "a folder without a skill", target))
    policy = make_policy(_without_memory(expert))
    found = [one for folder in folders for one in episodes(folder)]
    say(f"{len(found)} episodes; asking {expert.id} in each state and {recipe.beside} beside it")
    labels = label(policy, found, recipe.beside, recipe.seed)
    say(f"{len(labels.states)} labels; training {recipe.epochs} epochs")
    model, statistics, error = _network(labels, recipe, expert)
    target.mkdir(parents=True, exist_ok=True)
    (target / MODEL).write_bytes(model)
    written = json.dumps(statistics, indent=1) + "\n"
    (target / STATISTICS).write_text(written, encoding="utf-8")
    hashes = {MODEL: _sha256(model), STATISTICS: _sha256(written.encode())}
    (target / "rskill.yaml").write_text(
        yaml.safe_dump(_manifest(target.name, expert, recipe, hashes), sort_keys=False),
        encoding="utf-8",
    )
    told = {
        "recipe": asdict(recipe), "expert": expert.id, "libraries": libraries,
        "datasets": [_dataset(folder) for folder in folders],
        "labels": len(labels.states), "held_out_error": error, "sha256": hashes,
    }  # fmt: skip
    (target / RECIPE).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    say(f"{target}: {len(model) // 1024} KiB; squared error held out: {error:.4f} of a variance")


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
    centre, spread = labels.states.mean(0), labels.states.std(0) + _LEAST_STD
    mean, std = rows.mean((0, 1)), rows.std((0, 1))
    std[std < _LEAST_STD] = 0.0
    outputs = ((rows - mean) / np.where(std > 0, std, 1.0)).reshape(count, -1)
    outputs[:, np.tile(std == 0, horizon)] = 0.0
    seen = features(centre, spread)
    inputs = seen((labels.states - centre) / spread)
    order = np.random.default_rng(recipe.seed).permutation(count)
    apart, used = order[: count // _HELD_OUT], order[count // _HELD_OUT :]
    net = fit(inputs[used], outputs[used], recipe.seed, recipe.widths, recipe.epochs)
    moving = np.tile(std > 0, horizon)
    error = float(((net.predict(inputs[apart]) - outputs[apart])[:, moving] ** 2).mean())
    statistics = {
        "observation.state": _block(state_names(expert), centre, spread),
        "action": _block(action_names(expert), mean, std),
    }
    return onnx_bytes(seen, net, horizon, dim), statistics, error


def _block(names: Sequence[str], mean: Any, std: Any) -> dict[str, Any]:
    return {"names": list(names), "mean": mean.tolist(), "std": std.tolist()}


def _manifest(
    name: str, expert: SkillManifest, recipe: Recipe, hashes: dict[str, str]
) -> dict[str, Any]:
    """The expert's, with the network, and with clips and thresholds: a network overshoots."""
    document = expert.model_dump(mode="json", exclude_defaults=True)
    for slot in document["action_contract"]["slots"]:
        mode = slot.get("control_mode")
        if mode in ("gripper_position", "composite_mode"):
            slot["threshold"] = 0.0
        elif mode is not None:
            slot["clip"] = [-1.0, 1.0]
    model, statistics = ({"file": file, "sha256": hashes[file]} for file in (MODEL, STATISTICS))
    options = {"model": model, "statistics": statistics | {"form": "mean_std"}}
    return document | {
        "id": name,
        "model_family": "behaviour_cloning",
        "policy": {"backend": "onnx", "options": options},
        "execute_steps": recipe.execute_steps,
    }


def _dataset(folder: Path) -> dict[str, Any]:
    """What it is, with the SHA-256 of its states: all that is learned from it."""
    header = read_header(folder)
    states = b"".join(one.states.tobytes() for one in episodes(folder))
    return {
        "skill": header.skill, "skill_hash": header.skill_hash, "noise": header.noise,
        "seeds": [one.seed for one in header.episodes],
        "succeeded": sum(one.succeeded for one in header.episodes),
        "states_sha256": _sha256(states),
    }  # fmt: skip


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
