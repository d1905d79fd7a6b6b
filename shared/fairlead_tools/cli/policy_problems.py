"""What is wrong with a skill's ``policy.options``, for commands that check skills."""

from __future__ import annotations

from fairlead.errors import ConfigError
from fairlead.skill.manifest import SkillManifest


def policy_problems(skill: SkillManifest) -> list[str]:
    """Every reason why the skill's policy could not be loaded with its options; empty if none."""
    from fairlead_skill_runner.policies.backends import check_policy_options

    try:
        check_policy_options(skill)
    except ConfigError as error:
        return [str(error)]
    return []
