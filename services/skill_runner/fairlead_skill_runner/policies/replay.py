"""A policy that repeats a recording: the raw vectors of a runner's ``trace.jsonl``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.trace import read_trace


class ReplayOptions(BaseModel):
    """``trace``: path of the ``trace.jsonl`` that a runner wrote."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    trace: Path


class ReplayPolicy:
    """Gives the recorded chunks in the order they were recorded, whatever it observes."""

    def __init__(self, chunks: list[Actions]) -> None:
        self._chunks = chunks
        self._next = 0

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` where the recording is missing, empty or of another width."""
        path = checked_model("replay policy", ReplayOptions, options).trace
        chunks = [record.actions for record in read_trace(path)]
        dim = skill.action_contract.dim
        if not chunks:
            raise ConfigError(f"replay policy: {path}: expected recorded chunks, got none")
        for number, chunk in enumerate(chunks, start=1):
            if chunk.shape[1] != dim:
                raise ConfigError(
                    expected(f"replay policy: {path} line {number}", f"width {dim}", chunk.shape[1])
                )
        return cls(chunks)

    def infer(self, observation: Observation) -> Actions:
        """The next recorded chunk.

        Raises:
            PolicyError: when the recording has ended.
        """
        if self._next >= len(self._chunks):
            raise PolicyError(f"replay policy: the recording ends after {self._next} chunks")
        self._next += 1
        return self._chunks[self._next - 1].copy()

    def reset(self) -> None:
        """Start at the first chunk again."""
        self._next = 0
