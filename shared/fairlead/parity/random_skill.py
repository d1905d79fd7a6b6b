"""A skill of random vectors: what another has to say, replaced by numbers drawn from a seed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from fairlead.skill.manifest import SkillManifest, load_skill

CALLS_MOST = 800
"""More than an episode has; each refused call costs one, too."""


def write_random_skill(skills: Path, like: SkillManifest, scale: float, seed: int) -> SkillManifest:
    """Write it into a folder of skills, which FAIRLEAD_SKILLS has to name.

    Args:
        like: the skill whose state and action contracts it keeps.
        scale: every number is uniform in ``[-scale, scale]``, float32.
    """
    from fairlead_skill_runner.trace import TraceRecord, TraceWriter

    name = f"random-{like.id}"
    home = (skills / name).absolute()
    home.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    shape = (like.execute_steps, like.action_contract.dim)
    recording = TraceWriter(home / "vectors.jsonl")
    for call in range(CALLS_MOST):
        rows = rng.uniform(-scale, scale, shape).astype(np.float32)
        recording.write(TraceRecord(call, np.zeros(like.state_contract.dim), rows))
    recording.close()
    written = like.model_dump(mode="json", exclude_none=True) | {
        "id": name,
        "images": {},
        "policy": {"backend": "replay", "options": {"trace": str(home / "vectors.jsonl")}},
    }
    (home / "rskill.yaml").write_text(yaml.safe_dump(written), encoding="utf-8")
    return load_skill(name)
