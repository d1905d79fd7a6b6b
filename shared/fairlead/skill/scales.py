"""Scale and offset of a policy's numbers: value = scale * number + offset, in the slot's unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator

__all__ = ["Numbers", "scale_problems", "spread"]


def _listed(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError(f"expected a number, got {value}")
    if isinstance(value, str | dict):
        raise ValueError(f"expected a number, or a list of them, got {value!r}")
    return (value,) if isinstance(value, (int, float)) else value


Numbers = Annotated[tuple[float, ...], BeforeValidator(_listed)]
"""One number for all dimensions, or one for each."""


def spread(values: Numbers | None, default: float, width: int) -> tuple[float, ...]:
    """One for each of ``width`` dimensions."""
    if values is None:
        return (default,) * width
    return values * width if len(values) == 1 else values


def scale_problems(given: Mapping[str, Numbers | None], width: int) -> list[str]:
    """What is wrong with ``scale`` and ``offset`` of so many dimensions."""
    problems = []
    for name, values in given.items():
        if values is None:
            continue
        if len(values) not in (1, width):
            problems.append(f"{name}: expected 1 or {width} number(s), got {len(values)}")
        if not all(math.isfinite(v) for v in values) or (name == "scale" and 0.0 in values):
            kind = "finite and not 0" if name == "scale" else "finite"
            problems.append(f"{name}: expected numbers that are {kind}, got {list(values)}")
    return problems
