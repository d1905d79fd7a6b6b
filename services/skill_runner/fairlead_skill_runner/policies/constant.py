"""A policy that says what its file says: for first motions and for fault tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.policy import Actions, Done, Observation
from fairlead.skill.manifest import SkillManifest

_WHO = "constant policy"


class Phase(BaseModel):
    """row: one number per action dimension, said for so many ticks."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    row: tuple[float, ...]
    ticks: int = Field(ge=1)


class ConstantOptions(BaseModel):
    """row: one number per action dimension, said without end; or phases, one after the other.

    horizon: rows per call; None: the skill's.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    row: tuple[float, ...] | None = None
    phases: tuple[Phase, ...] = ()
    horizon: int | None = Field(default=None, ge=1)


class ConstantPolicy:
    """Repeats one row; or goes through phases, and is done after the last, whose row stays.

    Args:
        ticks: where each phase ends, counted from the first observation; (): none does.
    """

    def __init__(
        self, rows: Sequence[Sequence[float]], horizon: int, ticks: Sequence[int] = ()
    ) -> None:
        self._rows = np.asarray(rows, dtype=np.float32)
        self._ends, self._horizon = np.asarray(ticks, dtype=np.int64), horizon
        self._first_tick: int | None = None

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` where a row is not as wide as the skill's actions."""
        checked = checked_model(_WHO, ConstantOptions, options)
        if (checked.row is None) == (not checked.phases):
            got = "both" if checked.phases else "neither"
            raise ConfigError(expected(_WHO, "row or phases", got))
        rows = [checked.row] if checked.row is not None else [one.row for one in checked.phases]
        dim = skill.action_contract.dim
        for row in rows:
            if len(row) != dim:
                raise ConfigError(expected(_WHO, f"a row of {dim}", len(row)))
        ends = np.cumsum([one.ticks for one in checked.phases], dtype=np.int64)
        return cls(rows, checked.horizon or skill.horizon, ends.tolist())

    def infer(self, observation: Observation) -> Actions | Done:
        """Rows from that of this observation's tick on."""
        if self._first_tick is None:
            self._first_tick = observation.tick
        at = observation.tick - self._first_tick
        if self._ends.size and at >= self._ends[-1]:
            return Done("every phase is over")
        ticks = at + observation.periods * np.arange(self._horizon)
        phase = np.minimum(np.searchsorted(self._ends, ticks, "right"), len(self._rows) - 1)
        return np.array(self._rows[phase])

    def reset(self) -> None:
        """The next observation is where the first phase begins."""
        self._first_tick = None
