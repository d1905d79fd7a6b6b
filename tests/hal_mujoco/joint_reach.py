"""The fixed arm's deployment and the pose its skill reaches for."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.paths import repo_root
from fairlead.skill.manifest import load_skill

SOURCE = repo_root() / "compose" / "panda_mujoco.yaml"
SKILL = "panda-joint-reach"
RUNNER = {"skills": [SKILL]}
"""The runner's options: without the other skills it starts sooner."""


def goal_position() -> FloatArray:
    """Arm joints [rad] and finger opening [m] at the goal."""
    options = load_skill(SKILL).policy.options
    assert isinstance(options["target_rad"], list)
    return np.array([*options["target_rad"], options["opening_m"]], dtype=float)
