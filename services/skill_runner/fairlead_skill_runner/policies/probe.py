"""Somebody else's policy is asked once as it is loaded: what is wrong is known before a claim."""

from __future__ import annotations

from fairlead.errors import PolicyError
from fairlead.policy import Done, Failed, Policy
from fairlead.reason_text import words_of
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import policy_rows
from fairlead_skill_runner.policies.remote.served_policy import warm_up_observation


def ask_once(who: str, policy: Policy, skill: SkillManifest, way_out: str) -> None:
    """An episode of one question, of which the policy then knows nothing.

    Args:
        way_out: how a policy says that it cannot be asked.

    Raises:
        PolicyError: it raises, or answers with no rows of the skill's.
    """
    try:
        policy.reset()
        answer = policy.infer(warm_up_observation(skill))
        if not isinstance(answer, Done | Failed):
            policy_rows(answer, skill.action_contract.dim, skill.horizon)
        policy.reset()
    except (Exception, SystemExit) as error:
        raise PolicyError(
            f"{who}: asked with a probe observation: {words_of(error)}\n"
            f"  for a policy that cannot be asked before its goal: {way_out}"
        ) from error
