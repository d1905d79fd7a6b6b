"""What the shell offers after Tab: skills and robots by name; nothing rather than an error."""

from __future__ import annotations

from collections.abc import Iterable

from fairlead.errors import FairleadError
from fairlead.paths import robot_ids
from fairlead.skill.manifest import skill_ids


def complete_skill(incomplete: str) -> list[str]:
    """Skills that ship or are installed."""
    try:
        return _beginning(incomplete, skill_ids())
    except FairleadError:
        return []


def complete_robot(incomplete: str) -> list[str]:
    """Robots that ship and the user's own."""
    try:
        return _beginning(incomplete, robot_ids())
    except FairleadError:
        return []


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
