"""A policy behind an RLDX or GR00T server that is started with its sim policy wrapper."""

from __future__ import annotations

import secrets
import time
from collections.abc import Mapping
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Observation, ServerAddress
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.remote.modality_check import modality_problems
from fairlead_skill_runner.policies.remote.modality_config import (
    Dialect,
    ServerConfig,
    read_config,
)
from fairlead_skill_runner.policies.remote.served_policy import (
    RemoteOptions,
    check_remote_options,
    output_of,
    say,
    warm_up_observation,
)
from fairlead_skill_runner.policies.remote.zmq_link import WHO, ZmqLink

ADDRESS = ServerAddress(r"^tcp://[^/\s:]+:\d+$", "tcp://127.0.0.1:5555")


class NamedAction(BaseModel):
    """One of the server's outputs."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    width: int = Field(gt=0)


class RldxOptions(RemoteOptions):
    """How state and actions are called on the wire.

    Attributes:
        language_key: of the prompt.
        state: name -> first and last index in the layout's vector, both included.
        actions: names in the order of the action vector.
    """

    address: str = Field(pattern=ADDRESS.pattern)
    language_key: str
    state: dict[str, tuple[int, int]] = Field(min_length=1)
    actions: tuple[NamedAction, ...] = Field(min_length=1)


class RldxZmqPolicy:
    """Asks the server and puts its named outputs in order."""

    def __init__(self, skill: SkillManifest, options: RldxOptions) -> None:
        self._skill, self._options = skill, options
        self._link = ZmqLink(skill, options)
        self._session, self._first = secrets.token_hex(8), True
        self._server = ServerConfig(Dialect.CLASS, {})

    server_address = ADDRESS

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit, alone or with the skill."""
        check_rldx_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Find the server, hold what it says of itself against the skill, let it compile.

        Raises:
            ConfigError: for options that do not fit.
            PolicyError: if no server is there, it wants or gives something else, or it answers
                with other widths.
        """
        policy = cls(skill, check_rldx_options(skill, options))
        policy._link.dial()
        policy._warm_up()
        return policy

    def reset(self) -> None:
        """A socket of its own for every episode, which proves that a server is there.

        The server forgets the last episode. One that was started anew since then is checked, and
        compiles, again: now and not under a claim.

        Raises:
            PolicyError: as `from_options`.
        """
        if not self._link.dial():
            self._warm_up()
        # The same session again: a server that keeps sessions has one of ours, not one a goal.
        self._first = True
        if self._server.dialect is not Dialect.N1_5:  # which has no such endpoint
            self._link.ask("reset", {"options": {"session_ids": [self._session]}})

    def _warm_up(self) -> None:
        try:
            self._check_config()
        except PolicyError:
            self._link.close()
            raise
        begun_s = time.monotonic()
        rows = self._act(warm_up_observation(self._skill), self._options.warm_up_timeout_s)
        told = ", ".join(self._server.modalities) or "nothing"
        say(
            WHO,
            f"{self._options.address} speaks as {self._server.dialect.value}; it tells of its "
            f"modalities: {told}; asked with a probe observation it gave {list(rows.shape)} after "
            f"{time.monotonic() - begun_s:.2f} s",
        )

    def _check_config(self) -> None:
        self._link.arrays = "npy"
        answer = self._link.ask("get_modality_config")
        self._server = read_config(WHO, {} if answer is None else answer)
        self._link.arrays = self._server.dialect.arrays
        options = self._options
        problems = modality_problems(
            self._server.modalities,
            self._skill,
            options.state,
            [action.name for action in options.actions],
            options.language_key,
        )
        if problems:
            listed = "\n  ".join(problems)
            raise PolicyError(
                f"{WHO}: {options.address} does not serve this skill's policy:\n  {listed}"
            )

    def infer(self, observation: Observation) -> Actions:
        """The server's rows.

        Raises:
            PolicyError: if it fails, is late, goes away or answers anything else.
        """
        return self._act(observation, self._options.answer_timeout_s)

    def _act(self, observation: Observation, timeout_s: float) -> Actions:
        data: dict[str, object] = self._flat(observation)
        if self._server.dialect is not Dialect.N1_5:
            options = {"session_ids": [self._session], "reset_memory": [self._first]}
            data = {"observation": data, "options": options}
        try:
            reply = self._link.call({"endpoint": "get_action", "data": data}, timeout_s)
        except TimeoutError as error:
            raise PolicyError(f"{WHO}: {self._options.address}: {error}") from None
        self._first = False
        try:
            return self._rows(reply)
        except PolicyError:
            self._link.close()
            raise

    def _flat(self, observation: Observation) -> dict[str, object]:
        """Arrays are [batch 1, time, ...], for GR00T N1.5 [time, ...]."""
        batch = () if self._server.dialect is Dialect.N1_5 else (None,)
        state = observation.state.astype("<f4")
        return {
            **{
                f"video.{name}": observation.frames_of(name)[(*batch, ...)]
                for name in observation.images
            },
            **{
                f"state.{name}": state[(*batch, None, slice(first, last + 1))]
                for name, (first, last) in self._options.state.items()
            },
            self._options.language_key: [observation.prompt],
        }

    def _rows(self, reply: object) -> Actions:
        """``[{"action.<name>": [1, H, width], ...}, information]`` as ``[H, dim]``.

        GR00T N1.5 answers with the map alone, and without the batch axis.
        """
        named = reply[0] if isinstance(reply, list) and reply else None
        if self._server.dialect is Dialect.N1_5:
            named = reply
        if not isinstance(named, dict):
            raise PolicyError(expected(WHO, "a list that begins with a map", type(reply).__name__))
        blocks = []
        for action in self._options.actions:
            value = output_of(WHO, named, f"action.{action.name}")
            if isinstance(value, np.ndarray) and value.ndim == 3 and len(value) == 1:
                value = value[0]
            rows = float_rows(
                WHO, f"action.{action.name}", value, action.width, self._skill.horizon
            )
            blocks.append(rows)
        if len({len(block) for block in blocks}) != 1:
            lengths = ", ".join(str(len(block)) for block in blocks)
            raise PolicyError(expected(WHO, "as many rows of every action", lengths))
        return np.concatenate(blocks, axis=1)


def check_rldx_options(skill: SkillManifest, options: Mapping[str, JsonValue]) -> RldxOptions:
    """The options of an RLDX policy.

    Raises:
        ConfigError: for options that do not fit, alone or with the skill's contracts.
    """
    checked = check_remote_options(WHO, RldxOptions, options, skill)
    _check_widths(checked, skill)
    for name, spec in skill.images.items():
        if not spec.is_plain:
            got = f"{spec.dtype}, {spec.axes}"
            raise ConfigError(expected(f"{WHO}: images.{name}", "dtype uint8, axes hwc", got))
    return checked


def _check_widths(options: RldxOptions, skill: SkillManifest) -> None:
    """State and actions must be the skill's contracts, no more and no less."""
    names = [action.name for action in options.actions]
    if len(set(names)) < len(names):
        raise ConfigError(expected(f"{WHO}: actions", "each name once", names))
    width = sum(action.width for action in options.actions)
    if width != skill.action_contract.dim:
        raise ConfigError(
            expected(f"{WHO}: actions", f"{skill.action_contract.dim} numbers in all", width)
        )
    indices = sorted(i for first, last in options.state.values() for i in range(first, last + 1))
    dim = skill.state_contract.dim
    if indices != list(range(dim)):
        raise ConfigError(
            expected(f"{WHO}: state", f"every index of 0..{dim - 1} once", f"indices {indices}")
        )
