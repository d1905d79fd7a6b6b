"""What is wrong with a goal before anything is started for it."""

from __future__ import annotations

from fairlead.errors import ConfigError
from fairlead.messages import NO_HASH, Goal
from fairlead.skill.manifest import SkillManifest


def check_goal(goal: Goal, skill: SkillManifest) -> None:
    """Raise `ConfigError` for a goal whose numbers cannot be meant, or for another manifest."""
    if not 0.0 < goal.stall_timeout_s < float("inf"):
        raise ConfigError(
            f"goal: stall_timeout_s: expected more than 0 s, got {goal.stall_timeout_s:g}"
        )
    if goal.skill_hash not in (NO_HASH, skill.skill_hash):
        raise ConfigError(
            f"goal: skill {skill.id}: expected the manifest {skill.skill_hash.hex()[:16]} this "
            f"runner has loaded, got {goal.skill_hash.hex()[:16]}"
        )
