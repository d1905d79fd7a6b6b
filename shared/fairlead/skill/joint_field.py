"""Joint-space state vectors: which joints, in which order, what of them, in which unit.

For a policy that was trained on the joints themselves there is no layout to name, only an
order and units. Nothing is left to a default: a number of another unit looks like any other.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Quantity = Literal["position", "velocity"]
JointUnit = Literal["rad", "deg", "m", "rad/s", "deg/s", "m/s"]

UNITS: dict[Quantity, tuple[JointUnit, ...]] = {
    "position": ("rad", "deg", "m"),
    "velocity": ("rad/s", "deg/s", "m/s"),
}
"""Units of each quantity; the last one is a sliding joint's."""


class JointField(BaseModel):
    """Some joints' measurements, side by side in the state vector.

    Attributes:
        names: the robot's joints, commanded or only measured (fingers), in the policy's order.
        quantity: what of them.
        unit: of the policy's numbers.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    names: tuple[str, ...] = Field(min_length=1)
    quantity: Quantity
    unit: JointUnit

    @model_validator(mode="after")
    def _check_unit(self) -> Self:
        valid = UNITS[self.quantity]
        if self.unit not in valid:
            raise ValueError(
                f"unit: expected one of a {self.quantity}, got {self.unit!r} "
                f"(valid: {', '.join(valid)})"
            )
        return self

    @property
    def per_si(self) -> float:
        """What one SI unit (rad or m, per second or not) is in this unit."""
        return 180.0 / math.pi if self.unit.startswith("deg") else 1.0

    def units_of(self, joint_type: str) -> tuple[JointUnit, ...]:
        """Units of this quantity for joints that slide (``prismatic``), or turn."""
        *turning, sliding = UNITS[self.quantity]
        return (sliding,) if joint_type == "prismatic" else tuple(turning)


def joint_field_problems(dim: int, fields: Sequence[JointField]) -> list[str]:
    """What is wrong with a vector of ``dim`` numbers that is to hold these fields."""
    given = Counter((field.quantity, name) for field in fields for name in field.names)
    problems = [
        f"joints: the {quantity} of {name!r} is given {count} times"
        for (quantity, name), count in given.items()
        if count > 1
    ]
    width = sum(len(field.names) for field in fields)
    if dim != width:
        problems.append(f"dim: expected {width}, one per joint in joints, got {dim}")
    return problems
