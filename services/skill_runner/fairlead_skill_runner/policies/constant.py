"""A policy that always says the same: for first motions and for fault tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest


class ConstantOptions(BaseModel):
    """row: one number per action dimension. horizon: rows per call; None: the skill's."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    row: tuple[float, ...]
    horizon: int | None = Field(default=None, ge=1)


class ConstantPolicy:
    """Repeats one row."""

    def __init__(self, row: tuple[float, ...], horizon: int) -> None:
        self._actions: Actions = np.tile(np.asarray(row, dtype=np.float32), (horizon, 1))

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` where the row is not as wide as the skill's actions."""
        checked = checked_model("constant policy", ConstantOptions, options)
        dim = skill.action_contract.dim
        if len(checked.row) != dim:
            raise ConfigError(expected("constant policy", f"a row of {dim}", len(checked.row)))
        return cls(checked.row, checked.horizon or skill.horizon)

    def infer(self, observation: Observation) -> Actions:
        """The same rows for every observation."""
        return self._actions.copy()

    def reset(self) -> None:
        """Nothing to forget."""
