"""What a skill's action contract says against what its checkpoint was trained on.

A dimension that never moved in training but is routed commands noise; one that moved but
is discarded is motion that is lost. Both are easy to write and hard to see in a run.
"""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import SkillManifest
from fairlead_tools.skills.checkpoint_stats import DimensionStats


def contract_findings(contract: ActionContract, actions: Sequence[DimensionStats]) -> list[str]:
    """Every dimension whose statistics contradict the contract, in order.

    Statistics may be wider than the contract where the surplus is constant padding.
    """
    surplus = [index for index in range(contract.dim, len(actions)) if not actions[index].constant]
    if len(actions) < contract.dim or surplus:
        return [f"action_contract: dim {contract.dim}, the statistics have {len(actions)}"]
    routed = {index: slot for slot in contract.routed for index in range(slot.first, slot.last + 1)}
    findings = []
    for index, stats in enumerate(actions[: contract.dim]):
        slot = routed.get(index)
        if slot is not None and stats.constant:
            findings.append(
                f"dimension {index}: constant in training ({stats.evidence}), but {slot.name} "
                "commands it"
            )
        elif slot is None and not stats.constant:
            findings.append(
                f"dimension {index}: active in training ({stats.evidence}), but discarded"
            )
    return findings


def named_outputs(skill: SkillManifest) -> tuple[str, ...]:
    """The names of a policy's outputs in order, where its options give them; else empty."""
    actions = skill.policy.options.get("actions")
    if not isinstance(actions, list):
        return ()
    return tuple(str(item["name"]) for item in actions if isinstance(item, dict))
