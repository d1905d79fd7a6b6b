"""The scripted expert for the task ReachCube: from where hand and cube are, without memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest

LAYOUT, ACTION_DIM = "mobile_pick_30d", 7
ABOVE_M = 0.1
"""Of the hand above the cube's centre when it is there."""
HIGHER = 0.3
"""So much higher for each metre that it still is beside it: it comes from above."""
GAIN = np.array([0.5, 0.5, 0.25])
"""Of the way that is left, the share that is one step's goal: down slowly, for the gate reckons
with all of a chunk, and the table is near."""
STEP_M, SCALE_M = 0.014, 0.05
"""Longest goal of a step along an axis, and what a number of 1 is."""


class _NoOptions(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ReachCubeOracle:
    """Towards the point above the cube, the hand open."""

    def __init__(self, horizon: int) -> None:
        self._horizon = horizon

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` for any option, and a skill whose numbers it does not know."""
        checked_model("reach cube oracle", _NoOptions, options)
        layout, dim = skill.state_contract.layout_name, skill.action_contract.dim
        if (layout, dim) != (LAYOUT, ACTION_DIM):
            what = f"{LAYOUT} and {ACTION_DIM} numbers of an action"
            raise ConfigError(expected(f"reach cube oracle: {skill.id}", what, f"{layout}, {dim}"))
        return cls(skill.horizon)

    def infer(self, observation: Observation) -> Actions:
        """The same row again and again, float32 ``[horizon, 7]``."""
        return np.tile(_row(observation.state), (self._horizon, 1)).astype(np.float32)

    def reset(self) -> None:
        """Nothing to forget."""


def _row(state: FloatArray) -> FloatArray:
    """For a ``mobile_pick_30d`` vector: float64 ``[7]``, in shares of full scale."""
    way = state[16:19] - state[0:3]  # from the hand to the cube, in base_link
    way[2] += ABOVE_M + HIGHER * np.linalg.norm(way[:2])
    row = np.zeros(ACTION_DIM)
    row[:3] = np.clip(GAIN * way, -STEP_M, STEP_M) / SCALE_M
    row[6] = -1.0
    return row
