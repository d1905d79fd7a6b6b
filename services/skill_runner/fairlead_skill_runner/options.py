"""The runner's own block in a deployment file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.errors import ConfigError, expected
from fairlead.plugins import POLICIES
from fairlead.skill.manifest import PolicySpec, SkillManifest, skill_ids
from fairlead_skill_runner.policies.backends import server_address

MAX_ADDED_LATENCY_MS = 10_000.0
SIMULATED = "sim"
"""The profile of robots that hurt nobody."""


class ServerSpec(BaseModel):
    """Where a policy's server is, and where the key is that it asks for; a text is an address."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    address: str
    api_key_env: str | None = None
    api_key_file: str | None = None

    @model_validator(mode="before")
    @classmethod
    def _address_alone(cls, data: Any) -> Any:
        return {"address": data} if isinstance(data, str) else data


_KEY_OPTIONS = ("api_key_env", "api_key_file")
"""Of the manifest's server: another one gets no key that is not its own."""


class RunnerOptions(BaseModel):
    """``options`` of a service that runs ``skill_runner``.

    skills: ids of the skills this runner offers; None: every skill made for its robot.
    trace: write ``trace.jsonl`` (state and raw actions of every policy call) per goal.
    policies: by skill id, a policy to run instead of the manifest's own.
    servers: by skill id, where its policy server is, instead of the manifest's address and key; or
        that and where the server's key is.
    added_latency_ms: every answer of a policy comes so much later, to see what a slow one does;
        in a simulator only.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    skills: tuple[str, ...] | None = Field(default=None, min_length=1)
    trace: bool = False
    policies: dict[str, PolicySpec] = Field(default_factory=dict)
    servers: dict[str, ServerSpec] = Field(default_factory=dict)
    added_latency_ms: float = Field(default=0.0, ge=0.0, le=MAX_ADDED_LATENCY_MS)

    @model_validator(mode="after")
    def _policies_belong_to_skills(self) -> Self:
        offered = skill_ids() if self.skills is None else self.skills
        for skill in self.policies:
            if skill not in offered:
                raise ValueError(
                    f"policies: expected one of this runner's skills, got {skill!r} "
                    f"(valid: {', '.join(offered)})"
                )
        for skill in self.policies.keys() & self.servers.keys():
            raise ValueError(f"skill {skill}: expected it in policies or in servers, got both")
        return self

    @field_validator("policies")
    @classmethod
    def _known_backends(cls, value: dict[str, PolicySpec]) -> dict[str, PolicySpec]:
        for skill, policy in value.items():
            try:
                POLICIES.find(policy.backend, f"{skill}.backend")
            except ConfigError as error:
                raise ValueError(str(error)) from None
        return value

    def policy(self, skill: SkillManifest) -> PolicySpec:
        """What runs for a skill: its own policy, or what the options say instead."""
        own = self.policies.get(skill.id, skill.policy)
        server = self.servers.get(skill.id)
        if server is None:
            return own
        told = server.model_dump(exclude_none=True)
        kept = {name: own.options[name] for name in own.options if name not in _KEY_OPTIONS}
        return PolicySpec(backend=own.backend, options={**kept, **told})

    def check_profile(self, service: str, profile: str) -> None:
        """Raise ConfigError if something is asked for that is for a simulator only."""
        if self.added_latency_ms and profile != SIMULATED:
            who = f"service {service}: options.added_latency_ms"
            raise ConfigError(expected(who, f"0 in profile {profile}", self.added_latency_ms))

    def check_servers(self, skills: Mapping[str, SkillManifest]) -> None:
        """Let the addresses of policy servers pass.

        Args:
            skills: on offer, by id.

        Raises:
            ConfigError: for the server of a skill that is not on offer or has no server, and
                for an address that does not fit its protocol.
        """
        for name, server in self.servers.items():
            who = f"runner: servers.{name}"
            if name not in skills:
                raise ConfigError(expected(who, "one of this runner's skills", repr(name), skills))
            backend = skills[name].policy.backend
            form = server_address(backend)
            if form is None:
                raise ConfigError(expected(who, "a skill whose policy is a server", backend))
            if not re.search(form.pattern, server.address):
                what = f"an address such as {form.example}"
                raise ConfigError(expected(who, what, repr(server.address)))
