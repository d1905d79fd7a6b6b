"""Run with an interpreter that has lerobot: it makes small policies, and says what two of them say.

``python -m tests.peers.make_lerobot FOLDER``: a checkpoint in a folder each; beside those of
``act`` and ``diffusion`` ``act.npz``: what they saw, and lerobot's own rows for it.

``wild`` moves as nothing can, ``unknown`` has no statistics, ``nan`` a weight that is none.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

SEED, STATE, DIM, SIDE_PX, CHUNK = 7, 8, 7, 64, 12
EYE = "observation.images.eye"
SMALL: dict[str, dict[str, Any]] = {
    "act": {
        "chunk_size": CHUNK, "n_action_steps": CHUNK, "dim_model": 32, "n_heads": 2,
        "dim_feedforward": 32, "n_encoder_layers": 1, "n_vae_encoder_layers": 1,
    },
    "diffusion": {
        "horizon": 16, "n_action_steps": CHUNK, "down_dims": (16, 32), "n_groups": 4,
        "diffusion_step_embed_dim": 16, "num_inference_steps": 4, "crop_shape": (56, 56),
        "crop_ratio": 1.0, "spatial_softmax_num_keypoints": 8,
    },
}  # fmt: skip


def make(name: str, folder: Path) -> None:
    """Random weights, statistics of a hand that moves slowly, and lerobot's own files."""
    kind = name if name in SMALL else "act"
    torch = importlib.import_module("torch")
    types = importlib.import_module("lerobot.configs.types")
    factory = importlib.import_module("lerobot.policies.factory")
    feature, kinds = types.PolicyFeature, types.FeatureType
    rng = np.random.default_rng(SEED)
    torch.manual_seed(SEED)
    config = factory.make_policy_config(
        kind,
        input_features={
            "observation.state": feature(kinds.STATE, (STATE,)),
            EYE: feature(kinds.VISUAL, (3, SIDE_PX, SIDE_PX)),
        },
        output_features={"action": feature(kinds.ACTION, (DIM,))},
        device="cpu", pretrained_backbone_weights=None, push_to_hub=False, **SMALL[kind],
    )  # fmt: skip
    sizes = {"observation.state": (STATE,), EYE: (3, 1, 1), "action": (DIM,)}
    stats = {
        name: {
            "mean": rng.uniform(-0.05, 0.05, shape), "std": rng.uniform(0.01, 0.03, shape),
            "min": np.full(shape, -0.1), "max": rng.uniform(0.1, 0.2, shape),
        }
        for name, shape in sizes.items()
    }  # fmt: skip
    if name == "wild":
        stats["action"]["std"] *= 1000
    policy = factory.get_policy_class(kind)(config)
    if name == "nan":
        policy.model.action_head.bias.data[3] = float("nan")
    policy.save_pretrained(folder)
    known = None if name == "unknown" else stats
    for pipeline in factory.make_pre_post_processors(config, dataset_stats=known):
        pipeline.save_pretrained(folder)


def ask(folder: Path) -> None:
    """Lerobot's own words: its observations, its queues, its chunk, an action at a time."""
    torch = importlib.import_module("torch")
    configs = importlib.import_module("lerobot.configs.policies")
    factory = importlib.import_module("lerobot.policies.factory")
    tools = importlib.import_module("lerobot.policies.utils")
    config = configs.PreTrainedConfig.from_pretrained(folder)
    policy = factory.get_policy_class(config.type).from_pretrained(folder)
    before, after = factory.make_pre_post_processors(config, pretrained_path=str(folder))
    rng, times = np.random.default_rng(SEED), config.n_obs_steps
    states = rng.normal(size=(times, STATE))
    eyes = rng.integers(0, 256, (times, SIDE_PX, SIDE_PX, 3), np.uint8)
    policy.reset()
    batch: dict[str, Any] = {}
    for state, eye in zip(states.astype(np.float32), eyes, strict=True):
        seen = {"observation.state": state, EYE: eye}
        batch = before(tools.prepare_observation_for_inference(seen, torch.device("cpu"), "go"))
        policy.select_action(dict(batch))
    if config.type == "diffusion":
        batch["observation.images"] = batch[EYE]
    torch.manual_seed(SEED)
    chunk = policy.predict_action_chunk(batch)
    rows = torch.cat([after(chunk[:, index]) for index in range(chunk.shape[1])])
    np.savez(folder.with_suffix(".npz"), states=states, eyes=eyes, rows=rows.numpy())


if __name__ == "__main__":
    importlib.import_module("torch").set_num_threads(1)
    for name in ("act", "diffusion", "wild", "unknown", "nan"):
        make(name, Path(sys.argv[1]) / name)
    for name in SMALL:
        ask(Path(sys.argv[1]) / name)
