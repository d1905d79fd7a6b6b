"""The runner's own block in a deployment file."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fairlead.errors import ConfigError, expected
from fairlead.skill import PolicySpec, SkillManifest, load_skill, skill_ids


class RunnerOptions(BaseModel):
    """``options`` of a service that runs ``skill_runner``.

    skills: ids of the skills this runner offers; None: every skill made for its robot.
    trace: write ``trace.jsonl`` (state and raw actions of every policy call) per goal.
    policies: by skill id, a policy to run instead of the manifest's own.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    skills: tuple[str, ...] | None = Field(default=None, min_length=1)
    trace: bool = False
    policies: dict[str, PolicySpec] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _policies_belong_to_skills(self) -> Self:
        offered = skill_ids() if self.skills is None else self.skills
        for skill in self.policies:
            if skill not in offered:
                raise ValueError(
                    f"policies: expected one of this runner's skills, got {skill!r} "
                    f"(valid: {', '.join(offered)})"
                )
        return self

    def manifests(self, robot: str) -> dict[str, SkillManifest]:
        """The manifests of the skills on offer.

        Raises:
            ConfigError: for a manifest that does not load, or where none is left.
        """
        if self.skills is not None:
            return {skill: load_skill(skill) for skill in self.skills}
        found = {skill: load_skill(skill) for skill in skill_ids()}
        mine = {skill: made for skill, made in found.items() if robot in made.embodiments}
        if not mine:
            raise ConfigError(expected("runner", f"a skill made for {robot}", "none", found))
        return mine


def check_runner_options(service: str, options: dict[str, Any]) -> RunnerOptions:
    """Validate the options block.

    Raises:
        ConfigError: naming the service and every field that does not fit.
    """
    try:
        return RunnerOptions.model_validate(options)
    except ValidationError as error:
        problems = [
            f"  {'.'.join(str(part) for part in item['loc']) or 'options'}: {item['msg']}"
            for item in error.errors()
        ]
        raise ConfigError(f"service {service}: options:\n" + "\n".join(problems)) from None
