"""The runner's own block in a deployment file."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fairlead.errors import ConfigError
from fairlead.skill import PolicySpec


class RunnerOptions(BaseModel):
    """``options`` of a service that runs ``skill_runner``.

    skills: ids of the skills this runner offers.
    trace: write ``trace.jsonl`` (state and raw actions of every policy call) per goal.
    policies: by skill id, a policy to run instead of the manifest's own.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    skills: tuple[str, ...] = Field(min_length=1)
    trace: bool = False
    policies: dict[str, PolicySpec] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _policies_belong_to_skills(self) -> Self:
        for skill in self.policies:
            if skill not in self.skills:
                raise ValueError(
                    f"policies: expected one of this runner's skills, got {skill!r} "
                    f"(valid: {', '.join(self.skills)})"
                )
        return self


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
