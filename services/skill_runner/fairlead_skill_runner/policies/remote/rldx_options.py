"""How a skill's state and actions are called on the wire of an RLDX or GR00T server."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.errors import ConfigError, expected
from fairlead.policy import ServerAddress
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.remote.served_policy import (
    RemoteOptions,
    check_remote_options,
)
from fairlead_skill_runner.policies.remote.zmq_link import WHO

ADDRESS = ServerAddress(
    r"^tcp://([^/\s:\[\]]+|\[[0-9A-Fa-f:.%]+\]):[0-9]{1,5}$", "tcp://127.0.0.1:5555"
)


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
        rtc: real-time chunking: the server gets `Observation.prefix`, and its answers go on from
            it. It must have been started with RTC on.
    """

    address: str = Field(pattern=ADDRESS.pattern)
    language_key: str
    state: dict[str, tuple[int, int]] = Field(min_length=1)
    actions: tuple[NamedAction, ...] = Field(min_length=1)
    rtc: bool = False


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
