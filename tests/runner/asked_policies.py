"""Policies behind servers: which are asked, with what, and what comes of it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import numpy as np
import pytest

from fairlead.errors import PolicyError
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policy_worker import PolicyWorker

PI05 = "pi05-robocasa365-human300-nf4"
RLDX = "rldx1-ft-rc365-nf4"
ROWS = np.random.default_rng(5).uniform(-1, 1, (4, 12)).astype(np.float32)


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
