"""What ``fairlead serve-policy`` tells of the skill that it serves, and what a client makes of it.

openpi's own servers tell nothing of the kind: a probe observation shows their widths.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from fairlead.errors import PolicyError, expected
from fairlead.skill.manifest import SkillManifest

KEY = "fairlead"
"""Of this map in openpi's metadata, where others have names of their own."""

Told = dict[str, str | int | float]


def told_of(skill: SkillManifest) -> Told:
    """Dimensions are numbers in a vector, horizon and execute_steps rows.

    contracts: begins the SHA-256 of both, which say what each number is.
    """
    contracts = skill.state_contract.model_dump_json() + skill.action_contract.model_dump_json()
    return {
        "skill": skill.id,
        "version": skill.version,
        "layout": skill.state_contract.layout_name,
        "state_dim": skill.state_contract.dim,
        "action_dim": skill.action_contract.dim,
        "horizon": skill.horizon,
        "execute_steps": skill.execute_steps,
        "rate_hz": skill.rate_hz,
        "contracts": hashlib.sha256(contracts.encode()).hexdigest()[:16],
    }


def check_served(
    who: str, address: str, metadata: Mapping[object, object], skill: SkillManifest, serves: str
) -> None:
    """Let a server pass that tells nothing, or nothing that differs.

    Args:
        serves: the skill it may tell instead, in any version; "": the same.

    Raises:
        PolicyError: naming all that differs.
    """
    told, ours = metadata.get(KEY, {}), told_of(skill)
    if not isinstance(told, dict):
        raise PolicyError(expected(who, f"{KEY} as a map from {address}", type(told).__name__))
    if serves:
        ours["skill"] = serves
        del ours["version"], ours["contracts"]
    differs = [
        f"{name}: expected {value}, it serves {told[name]}"
        for name, value in ours.items()
        if name in told and told[name] != value
    ]
    if differs:
        listed = "\n  ".join(differs)
        other = "for a skill of another name: serves: ID in the policy's options"
        raise PolicyError(
            f"{who}: {address} serves another policy than skill {skill.id} asks for:\n  {listed}"
            + (f"\n  {other}" if "skill" in told and told["skill"] != ours["skill"] else "")
        )
