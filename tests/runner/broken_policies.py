"""Policies that misbehave in one way each, loaded into a real worker process."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from fairlead.policy import Done, Failed, Observation
from fairlead.skill.manifest import SkillManifest


class Misbehaving:
    """Returns eight good rows unless a subclass does worse."""

    def __init__(self, skill: SkillManifest) -> None:
        self.rows = np.zeros((skill.horizon, skill.action_contract.dim), dtype=np.float32)
        self.resets = 0

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        return cls(skill)

    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows

    def reset(self) -> None:
        self.resets += 1


class Echo(Misbehaving):
    """Row 0 says what arrived: tick, state[1], prompt length, a pixel, resets so far, the
    answer whose row the base executed, the last tick that was released."""

    def infer(self, observation: Observation) -> np.ndarray:
        pixel = observation.images["eye"][1, 0, 2] if observation.images else -1
        self.rows[0, :5] = [
            observation.tick,
            observation.state[1],
            len(observation.prompt),
            pixel,
            self.resets,
        ]
        if observation.judged is not None:
            base = observation.executed["base"].answer_tick
            self.rows[0, 5:7] = [base, observation.judged.last_tick]
        return self.rows


class Hangs(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        threading.Event().wait()
        return self.rows


class Dies(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        os._exit(7)


class Raises(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        raise ValueError("no such token")


class TooNarrow(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows[:, :11]


class TooLong(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return np.concatenate([self.rows, self.rows])


class Flat(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return np.asarray(self.rows[0])


class Doubles(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        return self.rows.astype(np.float64)


class NotANumber(Misbehaving):
    def infer(self, observation: Observation) -> np.ndarray:
        self.rows[2, 3] = np.nan
        return self.rows


class CannotLoad(Misbehaving):
    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        raise FileNotFoundError("weights.bin")


class NeverLoads(Misbehaving):
    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        threading.Event().wait()
        return cls(skill)


class SaysDone(Misbehaving):
    def infer(self, observation: Observation) -> Done:  # type: ignore[override]
        return Done("the drawer is shut")


class GivesUp(Misbehaving):
    def infer(self, observation: Observation) -> Failed:  # type: ignore[override]
        return Failed("object_lost", "nothing is in the hand")


class GivesUpBadly(Misbehaving):
    def infer(self, observation: Observation) -> Failed:  # type: ignore[override]
        return Failed("Object lost!", "")
