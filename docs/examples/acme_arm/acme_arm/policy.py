"""acme_reach: bring both joints to a pose, in steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError

from fairlead import SkillManifest
from fairlead.errors import ConfigError
from fairlead.policy import Actions, Done, Observation


class ReachOptions(BaseModel):
    """target_rad: where to. step_rad: the most a joint moves in a control period."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    target_rad: tuple[float, float]
    step_rad: float = Field(default=0.04, gt=0.0, le=0.05)


class ReachPolicy:
    """Sees the layout ``acme_tip_5d``; its rows are both joints' targets [rad]."""

    def __init__(self, options: ReachOptions, horizon: int) -> None:
        self._target, self._step = np.array(options.target_rad), options.step_rad
        self._horizon = horizon

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> ReachOptions:
        try:
            return ReachOptions.model_validate(options)
        except ValidationError as error:
            raise ConfigError(f"acme_reach: {error}") from None

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        return cls(cls.check_options(skill, options), skill.horizon)

    def reset(self) -> None: ...

    def infer(self, observation: Observation) -> Actions | Done:
        joints = observation.state[3:5]
        way = self._target - joints
        if np.abs(way).max() < 1e-6:
            x, y, z = observation.state[:3]
            return Done(f"the tip is at {x:.3f} {y:.3f} {z:.3f}")
        steps = np.arange(1, self._horizon + 1)[:, None] * self._step
        rows = joints + np.sign(way) * np.minimum(np.abs(way), steps)
        return np.asarray(rows, dtype=np.float32)
