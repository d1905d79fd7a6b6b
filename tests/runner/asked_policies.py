"""Policies behind servers: which are asked, with what, and what comes of it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fairlead.errors import PolicyError
from fairlead.policy import Observation, PastAnswer
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policy_worker import PolicyWorker
from tests.runner.policy_servers import RLDX_SHARES, Array

PI05 = "pi05-robocasa365-human300-nf4"
RLDX = "rldx1-ft-rc365-nf4"
ROWS = np.random.default_rng(5).uniform(-1, 1, (4, 12)).astype(np.float32)
STATES = [
    "end_effector_position_relative", "end_effector_rotation_relative", "base_position",
    "base_rotation", "gripper_qpos",
]  # fmt: skip
LANGUAGE = "annotation.human.task_description"
FITTING: dict[str, Any] = {
    "video": [-6, -4, -2, 0], "state": STATES, "actions": list(RLDX_SHARES), "horizon": 16,
    "language": LANGUAGE, "pictures": list(load_skill(RLDX).images),
}  # fmt: skip
"""What a server tells that serves the policy of the skill `RLDX`; see `modality_config`."""


def observation(skill: SkillManifest, tick: int = 9) -> Observation:
    rng = np.random.default_rng(tick)
    frames = {
        name: rng.integers(0, 256, (len(spec.deltas), *spec.shape)).astype(np.uint8)
        for name, spec in skill.images.items()
    }
    images = {name: pixels[-1] for name, pixels in frames.items()}
    several = {name: pixels for name, pixels in frames.items() if len(pixels) > 1}
    return Observation(
        tick, rng.normal(size=skill.state_contract.dim), "put it there", images, frames=several
    )


def late(seen: Observation, width: int, count: int) -> tuple[Observation, Array]:
    """An observation before whose answer ``count`` released rows act; these."""
    rows = np.random.default_rng(8).uniform(-1, 1, (9, width)).astype(np.float32)
    none = np.zeros(9, bool)
    before = PastAnswer(seen.tick - 2, rows, 1, "released", none, none, ~none)
    return replace(seen, answers=(before,), delay_ticks=count - 1), rows[2 : 2 + count]


Ask = Callable[..., PolicyWorker]


def bits(answer: object) -> bytes:
    """Of rows; a policy may answer with an end of its goal too."""
    assert isinstance(answer, np.ndarray)
    return answer.tobytes()


def failure(call: Callable[[], object]) -> str:
    with pytest.raises(PolicyError) as caught:
        call()
    return str(caught.value)


async def refusal(call: Awaitable[object]) -> str:
    with pytest.raises(PolicyError) as caught:
        await call
    return str(caught.value)
