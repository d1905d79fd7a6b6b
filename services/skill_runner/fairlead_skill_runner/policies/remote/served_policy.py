"""What every policy behind a server has: an address, deadlines, a key, and how to start one."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_validator

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest


class RemoteOptions(BaseModel):
    """Where the server is and how long to wait for it.

    Attributes:
        address: of the server.
        start: how to start one; said when none is there.
        connect_timeout_s: longest wait for a server, at the start of every goal; twice it
            (a handshake and a greeting) must fit into the worker's time for a reset.
        warm_up_timeout_s: longest wait for the first answer, which may compile the model.
        answer_timeout_s: longest wait for any later one; less than the skill's
            ``inference_timeout_s``.
        api_key_env, api_key_file: at most one of them: the environment variable, or the file,
            that has the key for a server that asks for one. The key itself is in no option.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    address: str
    start: str = Field(min_length=1)
    connect_timeout_s: float = Field(gt=0, le=4.5, allow_inf_nan=False)
    warm_up_timeout_s: float = Field(default=100.0, gt=0, le=100, allow_inf_nan=False)
    answer_timeout_s: float = Field(gt=0, allow_inf_nan=False)
    api_key_env: str | None = Field(default=None, min_length=1)
    api_key_file: str | None = Field(default=None, min_length=1)

    @model_validator(mode="after")
    def _one_key(self) -> Self:
        if self.api_key_env is not None and self.api_key_file is not None:
            raise ValueError("api_key_env, api_key_file: expected one of them, got both")
        return self

    @property
    def key_source(self) -> str:
        """Where the key comes from, in words."""
        if self.api_key_env is not None:
            return f"the environment variable {self.api_key_env}"
        return f"the file {self.api_key_file}" if self.api_key_file is not None else "nowhere"

    def api_key(self, who: str) -> str | None:
        """The key; None if the server is to get none.

        Raises:
            PolicyError: the variable is not set, the file cannot be read, or the key is empty or
                more than one line.
        """
        if self.api_key_env is not None:
            key = os.environ.get(self.api_key_env, "")
        elif self.api_key_file is not None:
            try:
                key = Path(self.api_key_file).expanduser().read_text(encoding="utf-8").strip()
            except (OSError, ValueError) as error:
                raise PolicyError(f"{who}: api_key_file: cannot be read: {error}") from None
        else:
            return None
        if not key.isprintable() or not key:
            got = "more than one line of text" if key else "nothing"
            raise PolicyError(expected(who, f"an API key in {self.key_source}", got))
        return key


NO_MESSAGE = (ValueError, TypeError, RecursionError, MemoryError)
"""What decoding raises for bytes that are no message of a server's."""

SIGN_OF_LIFE_S = 1.0
"""How long a server that was idle may take for a ping; after that it is taken for another one."""

_LINE_MAX = 1000
"""Characters of a server's error that a goal's result repeats."""

Options = TypeVar("Options", bound=RemoteOptions)


def check_remote_options(
    who: str, model: type[Options], options: Mapping[str, JsonValue], skill: SkillManifest
) -> Options:
    """Validate ``options`` as ``model``.

    Raises:
        ConfigError: for options that do not fit, alone or with the skill's own deadline.
    """
    checked = checked_model(who, model, options)
    if checked.answer_timeout_s >= skill.inference_timeout_s:
        raise ConfigError(
            expected(
                f"{who}: answer_timeout_s",
                f"less than the skill's inference_timeout_s, {skill.inference_timeout_s:g} s",
                f"{checked.answer_timeout_s:g} s",
            )
        )
    return checked


def require_names(who: str, skill: SkillManifest, state: str, prompt: str) -> None:
    """Raises `ConfigError` unless state, prompt and pictures have a name each in a request."""
    names = [state, prompt, *skill.images]
    if len(set(names)) < len(names):
        raise ConfigError(expected(who, "another name for state, prompt and each picture", names))


def no_server(who: str, skill: SkillManifest, options: RemoteOptions, cause: object) -> PolicyError:
    """Nobody answers at the address: the cause and the way out."""
    return PolicyError(
        f"{who}: no policy server at {options.address}: {cause}\n"
        f"  start one: {options.start}\n"
        "  or, if one runs elsewhere, in the runner's options in the deployment file:\n"
        f"    servers: {{{skill.id}: ADDRESS}}"
    )


def busy_server(
    who: str, skill: SkillManifest, options: RemoteOptions, missing: str
) -> PolicyError:
    """Somebody listens at the address and says nothing: ``missing`` is what was awaited."""
    return PolicyError(
        f"{who}: {options.address} listens, but sent {missing} within "
        f"{options.connect_timeout_s:g} s: it is busy with another request, hangs, or is no "
        f"policy server; one is started with: {options.start}\n"
        f"  for one elsewhere, in the runner's options: servers: {{{skill.id}: ADDRESS}}"
    )


def taken_server(who: str, options: RemoteOptions, said: str) -> PolicyError:
    """The server takes one client at a time, and has one."""
    return PolicyError(
        f"{who}: {options.address} has no room: {said}; the policy of another skill, or another "
        "runner, is still connected to it"
    )


def refused_key(who: str, options: RemoteOptions, said: str) -> PolicyError:
    """The server wants a key, or another one."""
    way = (
        f"the key it got is from {options.key_source}"
        if options.key_source != "nowhere"
        else "it got no key: api_key_env: NAME (an environment variable) or api_key_file: PATH in "
        "the policy's options gives it one"
    )
    return PolicyError(f"{who}: {options.address} lets nobody in without a key: {said}; {way}")


def server_failed(who: str, address: str, said: str) -> str:
    """A server's error in one line; what else there is of it goes into the runner's log.

    Some libraries end a traceback with other lines than what was raised.
    """
    lines = said.strip().splitlines() or ["it does not say why"]
    raised = [line for line in lines if re.match(r"[\w.]*(Error|Exception|Interrupt)\b", line)]
    line = (raised or lines)[-1]
    if len(lines) > 1 or len(line) > _LINE_MAX:
        say(who, f"{address} failed; it says:\n{said}")
    return f"{who}: {address} failed: {line[:_LINE_MAX]}"


def say(who: str, text: str) -> None:
    """A line in the runner's log."""
    print(f"{who}: {text}", file=sys.stderr, flush=True)


def warm_up_observation(skill: SkillManifest) -> Observation:
    """Something to ask before the first goal, so that a server compiles, and shows its width.

    Pictures of zeros and 0.5 everywhere: four of them are a rotation, four zeros are none.
    """
    frames = {
        name: np.zeros((len(spec.deltas), *spec.shape), spec.number_type)
        for name, spec in skill.images.items()
    }
    contract = skill.state_contract
    states = np.full((len(contract.deltas), contract.dim), 0.5)
    for array in (states, *frames.values()):
        array.flags.writeable = False  # as in a goal
    images = {name: pixels[-1] for name, pixels in frames.items()}
    return Observation(0, states[-1], skill.prompt, images, frames=frames, earlier=states[:-1])


def output_of(who: str, outputs: Mapping[Any, object], name: str) -> object:
    """One output of a server's answer.

    Raises:
        PolicyError: naming those there are.
    """
    if name not in outputs:
        raise PolicyError(
            expected(who, f"an output {name}", "none of that name", map(str, outputs))
        )
    return outputs[name]
