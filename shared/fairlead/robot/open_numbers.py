"""``to_confirm`` of robot.yaml: numbers that a person has yet to give or confirm.

Each key leads to a number, or to a block of them, by names: ``joints.elbow.velocity_rad_s``,
``safety.sim.measured.elbow``. Its value says what the number is now and why that may be wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

CONFIRMED_ONLY = "hardware"
"""The profile that takes no number which nobody confirmed."""


def open_problems(document: object, keys: Mapping[str, str]) -> Iterator[str]:
    """Entries of ``to_confirm`` that lead to nothing, or do not say why."""
    for key, why in keys.items():
        if not _leads_somewhere(document, key):
            yield f"to_confirm: {key!r} leads to nothing that robot.yaml gives"
        if not why.strip():
            yield f"to_confirm: {key!r}: expected why, in words, got {why!r}"


def _leads_somewhere(document: object, key: str) -> bool:
    """Names may have dots in them, so each that fits is tried."""
    if isinstance(document, Mapping):
        inside = [(str(name), value) for name, value in document.items()]
    elif isinstance(document, list | tuple):
        named = [one for one in document if isinstance(one, Mapping) and "name" in one]
        inside = [(str(one["name"]), one) for one in named]
    else:
        return False
    return any(
        value is not None if key == name else _leads_somewhere(value, key.removeprefix(f"{name}."))
        for name, value in inside
        if key == name or key.startswith(f"{name}.")
    )
