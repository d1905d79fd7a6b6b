"""The runner's own block in a deployment file."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import PolicySpec, SkillManifest, load_skill, skill_ids
from fairlead_skill_runner.policies.remote.server_address import ADDRESS_FORMS

_LOG = logging.getLogger("runner.options")


class RunnerOptions(BaseModel):
    """``options`` of a service that runs ``skill_runner``.

    skills: ids of the skills this runner offers; None: every skill made for its robot.
    trace: write ``trace.jsonl`` (state and raw actions of every policy call) per goal.
    policies: by skill id, a policy to run instead of the manifest's own.
    servers: by skill id, where its policy server is, instead of the manifest's address.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    skills: tuple[str, ...] | None = Field(default=None, min_length=1)
    trace: bool = False
    policies: dict[str, PolicySpec] = Field(default_factory=dict)
    servers: dict[str, str] = Field(default_factory=dict)

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

    def manifests(self, robot: str) -> dict[str, SkillManifest]:
        """The manifests of the skills on offer; none if no installed skill is for this robot.

        One that does not load is left out, and the log says why.

        Raises:
            ConfigError: for a manifest that does not load and is listed in ``skills``.
        """
        if self.skills is not None:
            return {skill: load_skill(skill) for skill in self.skills}
        found = {}
        for skill in skill_ids():
            try:
                made = load_skill(skill)
            except ConfigError as error:
                _LOG.error("skill %s is left out: %s", skill, error)
                continue
            if robot in made.embodiments:
                found[skill] = made
        return found

    def replaced_policies(self, skills: Mapping[str, SkillManifest]) -> dict[str, PolicySpec]:
        """By skill id, what runs instead of the manifest's own policy.

        Args:
            skills: on offer, by id.

        Raises:
            ConfigError: for the server of a skill that is not on offer or has no server, and
                for an address that does not fit its protocol.
        """
        served = {
            skill: _policy_at(skill, skills, address) for skill, address in self.servers.items()
        }
        return {**self.policies, **served}


def _policy_at(name: str, skills: Mapping[str, SkillManifest], address: str) -> PolicySpec:
    who = f"runner: servers.{name}"
    if name not in skills:
        raise ConfigError(expected(who, "one of this runner's skills", repr(name), skills))
    policy = skills[name].policy
    form = ADDRESS_FORMS.get(policy.backend)
    if form is None:
        raise ConfigError(
            expected(who, "a skill whose policy is a server", policy.backend, ADDRESS_FORMS)
        )
    if not re.search(form.pattern, address):
        raise ConfigError(expected(who, f"an address such as {form.example}", repr(address)))
    return PolicySpec(backend=policy.backend, options={**policy.options, "address": address})


def check_runner_options(service: str, options: dict[str, Any]) -> RunnerOptions:
    """Validate the options block.

    Raises:
        ConfigError: naming the service and every field that does not fit.
    """
    return checked_model(f"service {service}: options", RunnerOptions, options)
