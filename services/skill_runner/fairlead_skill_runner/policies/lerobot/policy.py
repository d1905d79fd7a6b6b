"""A policy that LeRobot trained: its checkpoint, run by an interpreter that has LeRobot."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.paths import rskill_dir
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.lerobot.checkpoint import (
    STATE,
    check_dataset,
    check_told,
    feature_names,
    stamp_of,
)
from fairlead_skill_runner.policies.lerobot.other_python import WHO, OtherPython
from fairlead_skill_runner.policies.remote.served_policy import say, warm_up_observation


class LerobotOptions(BaseModel):
    """Which checkpoint, and who runs it.

    Attributes:
        python: the interpreter that has lerobot; ``~`` is the home folder.
        checkpoint: the folder with config.json, model.safetensors and the processors; one that is
            not absolute lies in the skill's folder.
        dataset: the LeRobotDataset that trained it: names, order and rate are compared.
        device: as PyTorch names it; None: as the checkpoint says, where it is there.
        seed: of what a policy draws; each episode begins with it.
        threads: of PyTorch on the CPU; their number decides over the last bits of an answer.
        rtc: real-time chunking: the policy gets `Observation.prefix`, and its chunks go on from it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    python: str = Field(min_length=1)
    checkpoint: str = Field(min_length=1)
    dataset: str | None = None
    device: str | None = None
    seed: int = Field(default=0, ge=0, lt=2**63)
    threads: int = Field(default=1, ge=1, le=1024)
    rtc: bool = False


class LerobotPolicy:
    """The chunk of rows that lerobot predicts, between the checkpoint's own processors.

    Attributes:
        continues_rows: its answers go on from `Observation.prefix`.
    """

    takes_states = True

    def __init__(self, skill: SkillManifest, options: LerobotOptions) -> None:
        self._skill, self._options = skill, options
        self.continues_rows = options.rtc
        folder = rskill_dir(skill.id)
        self._checkpoint = folder / Path(options.checkpoint).expanduser()
        if options.dataset is not None:
            check_dataset(skill, folder / Path(options.dataset).expanduser())
        self._load()

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit; no file is read."""
        checked_model(WHO, LerobotOptions, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Load the checkpoint, compare it with the skill's contracts, ask it once.

        Raises:
            ConfigError: for options or a checkpoint that do not fit.
            PolicyError: it cannot be loaded, or says anything but rows of finite numbers.
        """
        return cls(skill, checked_model(WHO, LerobotOptions, options))

    def infer(self, observation: Observation) -> Actions:
        """The first rows of the chunk, as many as the skill's horizon.

        Raises:
            PolicyError: if it fails or says anything else.
        """
        prefix = observation.prefix() if self._options.rtc else None
        return self._checked(self._chunk(observation, prefix))

    def reset(self) -> None:
        """An episode begins; a checkpoint that has changed since is loaded anew.

        Raises:
            ConfigError, PolicyError: as `from_options`.
        """
        if stamp_of(self._checkpoint) != self._stamp:
            self.close()
            self._load()
        self._other.reset(self._options.seed)

    def close(self) -> None:
        """End the process."""
        self._other.close()

    def _load(self) -> None:
        self._stamp = stamp_of(self._checkpoint)
        self._other = OtherPython(Path(self._options.python).expanduser())
        try:
            options = self._options
            told = self._other.load(self._checkpoint, options.device, options.threads, options.rtc)
            check_told(self._skill, self._checkpoint, told)
            if options.rtc and not told["rtc"]:
                wanted = "a policy with real-time chunking, or no rtc"
                got = f"{told['type']} of lerobot {told['lerobot']}"
                raise ConfigError(expected(f"{WHO}: rtc", wanted, got))
            self._names = feature_names(self._skill, told["inputs"])
            self._in_time = told["deltas"] is not None  # its arrays have an axis of frames
            self._probe(f"{told['type']} by lerobot {told['lerobot']} on {told['device']}")
        except BaseException:
            self.close()
            raise

    def _probe(self, what: str) -> None:
        """How many rows it gives is known once it has given some."""
        skill, begun_s = self._skill, time.monotonic()
        chunk = self._chunk(warm_up_observation(skill))
        took_s = time.monotonic() - begun_s
        self._checked(chunk)
        if len(chunk) < skill.execute_steps:
            wanted = f"at least the skill's execute_steps, {skill.execute_steps}"
            raise ConfigError(expected(f"{WHO}: rows of a chunk", wanted, len(chunk)))
        cut = len(chunk) > skill.horizon
        used = f", of which the first {skill.horizon} are used" if cut else ""
        say(WHO, f"{what}: chunks of {len(chunk)} rows{used}; the first took {took_s:.2f} s")
        if self._options.rtc:
            again = self._checked(self._chunk(warm_up_observation(skill), chunk[:1]))
            apart = np.abs(again[0] - chunk[0]).max()
            say(WHO, f"it goes on from a prefix of one row within {apart:.2g} of it")

    def _checked(self, chunk: Actions) -> Actions:
        horizon = self._skill.horizon
        dim = self._skill.action_contract.dim
        return float_rows(WHO, "actions", chunk[:horizon], dim, horizon)

    def _chunk(self, observation: Observation, prefix: Actions | None = None) -> Actions:
        arrays: dict[str, npt.NDArray[Any]] = {STATE: observation.states.astype("<f4")}
        arrays |= {its: observation.frames_of(ours) for ours, its in self._names.items()}
        if not self._in_time:
            arrays = {name: frames[-1] for name, frames in arrays.items()}
        if prefix is not None and len(prefix):
            arrays["action"] = prefix
        return self._other.infer(observation.prompt, arrays)
