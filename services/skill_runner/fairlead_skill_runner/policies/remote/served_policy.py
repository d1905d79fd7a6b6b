"""What every policy behind a server has: an address, deadlines, and how to start one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

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
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    address: str
    start: str = Field(min_length=1)
    connect_timeout_s: float = Field(gt=0, le=4.5, allow_inf_nan=False)
    warm_up_timeout_s: float = Field(default=100.0, gt=0, le=100, allow_inf_nan=False)
    answer_timeout_s: float = Field(gt=0, allow_inf_nan=False)


NO_MESSAGE = (ValueError, TypeError, RecursionError, MemoryError)
"""What decoding raises for bytes that are no message of a server's."""

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


def warm_up_observation(skill: SkillManifest) -> Observation:
    """Something to ask before the first goal, so that a server compiles, and shows its width.

    Black pictures and 0.5 everywhere: four of them are a rotation, four zeros are none.
    """
    images = {
        name: np.zeros((spec.height, spec.width, 3), dtype=np.uint8)
        for name, spec in skill.images.items()
    }
    return Observation(0, np.full(skill.state_contract.dim, 0.5), skill.prompt, images)


def output_of(who: str, outputs: Mapping[Any, object], name: str) -> object:
    """One output of a server's answer.

    Raises:
        PolicyError: naming those there are.
    """
    if name not in outputs:
        raise PolicyError(expected(who, f"an output {name}", "none of that name", outputs))
    return outputs[name]
