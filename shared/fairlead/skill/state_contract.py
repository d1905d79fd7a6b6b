"""The state vector a policy was trained on: a layout with its bindings, or joints side by side.

For a policy that was trained on the joints themselves there is no layout to name, only an order
and units. Nothing is left to a default: a number of another unit looks like any other.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.errors import ConfigError
from fairlead.layout import Layout, load_layout
from fairlead.plugins import LAYOUTS
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.deltas import NOW, Deltas
from fairlead.skill.scales import Numbers, scale_problems, spread

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
        scale, offset: as a slot's, for numbers in no unit: value in the unit = scale * number +
            offset; one number, or one per joint.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    names: tuple[str, ...] = Field(min_length=1)
    quantity: Quantity
    unit: JointUnit
    # Left out where they are not given, the hash of a skill stays what it was.
    scale: Numbers | None = Field(default=None, exclude_if=lambda scale: scale is None)
    offset: Numbers | None = Field(default=None, exclude_if=lambda offset: offset is None)

    @model_validator(mode="after")
    def _check(self) -> Self:
        valid = UNITS[self.quantity]
        if self.unit not in valid:
            raise ValueError(
                f"unit: expected one of a {self.quantity}, got {self.unit!r} "
                f"(valid: {', '.join(valid)})"
            )
        given = {"scale": self.scale, "offset": self.offset}
        if problems := scale_problems(given, len(self.names)):
            raise ValueError("\n".join(problems))
        return self

    @property
    def in_units(self) -> bool:
        """Whether the policy's numbers are the unit's own."""
        return self.scale is None and self.offset is None

    def numbers(self, measured: Sequence[float]) -> list[float]:
        """The policy's numbers of what the joints measure, in SI (rad or m, per second or not)."""
        per_si = 180.0 / math.pi if self.unit.startswith("deg") else 1.0
        scales = spread(self.scale, 1.0, len(self.names))
        offsets = spread(self.offset, 0.0, len(self.names))
        given = zip(measured, scales, offsets, strict=True)
        return [(per_si * value - offset) / scale for value, scale, offset in given]

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


class StateContract(BaseModel):
    """The state vector a policy was trained on: its size, and what each number is.

    Attributes:
        layout: what the numbers mean, for a vector with poses in it; or
        joints: for one of joints alone, what is side by side in it.
        bindings: which frames and joints of the robot fill a layout.
        deltas: at which moments the policy sees it, in rows of the policy (1 / ``rate_hz``) before
            the newest, which is 0; ascending. Before a goal's first state there is that one again.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    layout: str | None = None
    dim: int
    bindings: StateContractBindings = StateContractBindings()
    joints: tuple[JointField, ...] = ()
    # Left out where it is 0 alone, the hash of a skill stays what it was.
    deltas: Deltas = Field(default=NOW, exclude_if=lambda deltas: deltas == NOW)

    @field_validator("layout")
    @classmethod
    def _known_layout(cls, value: str | None) -> str | None:
        if value is not None:
            try:
                load_layout(value)
            except ConfigError as error:
                raise ValueError(str(error)) from None
        return value

    @property
    def layout_name(self) -> str:
        """What messages and errors call it."""
        return self.layout or "joints"

    @model_validator(mode="after")
    def _check_layout(self) -> Self:
        if self.layout is None or self.joints:
            problems = self._joint_space_problems()
        else:
            problems = self._layout_problems(self.layout)
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _joint_space_problems(self) -> list[str]:
        if not self.joints:
            return [f"expected layout or joints, got neither (layouts {LAYOUTS.choices()})"]
        given = {"layout": self.layout, "bindings": self.bindings.model_dump(exclude_defaults=True)}
        problems = [f"{name}: not allowed beside joints" for name, value in given.items() if value]
        return problems + joint_field_problems(self.dim, self.joints)

    def _layout_problems(self, name: str) -> list[str]:
        layout = load_layout(name)
        problems = []
        if layout.dim is not None and self.dim != layout.dim:
            problems.append(f"dim: expected {layout.dim} for layout {name}, got {self.dim}")
        missing = layout.missing(self.bindings)
        if missing:
            problems.append(f"bindings: layout {name} also needs {', '.join(missing)}")
        return problems + _unread(name, layout, self.bindings)


def _unread(name: str, layout: Layout, bindings: StateContractBindings) -> list[str]:
    """What is bound in vain: it would be a surprise if it were ignored."""
    problems = []
    wanted, named = len(layout.joint_names), len(bindings.joint_names)
    if named not in (0, wanted):
        other = "" if not wanted else "; joints in any number: state_contract.joints"
        problems.append(f"joint_names: expected {wanted} for layout {name}, got {named}{other}")
    read = layout.read
    given = bindings.model_dump(exclude_defaults=True)
    problems += [
        f"{binding}: layout {name} reads none (valid: {', '.join(read) or 'none'})"
        for binding, value in given.items()
        if value and binding not in (*read, "joint_names")
    ]
    problems += [
        f"quaternion_signs: layout {name} has no rotation of {frame}"
        for frame in bindings.quaternion_signs
        if "quaternion_signs" in read and frame not in layout.required
    ]
    return problems
