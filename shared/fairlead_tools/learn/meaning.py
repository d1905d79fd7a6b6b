"""What a skill's numbers and pictures mean: what is learned from some holds for no others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from fairlead.errors import expected
from fairlead.skill.manifest import SkillManifest

_OF_A_NETWORK = {"clip", "threshold"}  # a clone has others than its expert
_IN_SI = {"unit", "scale", "offset"}


def meaning(skill: SkillManifest) -> dict[str, Any]:
    """State, pictures, rows of a call and routed slots, for JSON; defaults are left out."""
    slots = sorted(skill.action_contract.routed, key=lambda slot: slot.first)
    return {
        "state_contract": skill.state_contract.model_dump(mode="json", exclude_defaults=True),
        "images": {
            name: spec.model_dump(mode="json", exclude_defaults=True, exclude={"contrast_min"})
            for name, spec in skill.images.items()
        },
        "horizon": skill.horizon,
        "slots": [
            slot.model_dump(mode="json", exclude_defaults=True, exclude=_OF_A_NETWORK | _IN_SI)
            | {"scale": list(slot.scales()), "offset": list(slot.offsets())}
            for slot in slots
        ],
    }


def differences(wanted: Any, got: Any, where: str = "") -> Iterator[str]:
    """Where two of them differ, in words."""
    if isinstance(wanted, dict) and isinstance(got, dict):
        for key in sorted({*wanted, *got}):
            below = f"{where}.{key}" if where else key
            yield from differences(wanted.get(key, "nothing"), got.get(key, "nothing"), below)
    elif isinstance(wanted, list) and isinstance(got, list) and len(wanted) == len(got):
        for index, (one, other) in enumerate(zip(wanted, got, strict=True)):
            yield from differences(one, other, f"{where}.{index}")
    elif wanted != got:
        yield expected(where, wanted, got)
