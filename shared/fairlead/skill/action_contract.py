"""The action vector a policy emits: its size, and what every index of it means.

A contract has slots, or, for policies that emit joint positions and nothing else, the
joints' names in the policy's order. The slots cover every index of ``[0, dim)`` exactly
once, so nothing a policy emits is dropped silently.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple, Self, cast

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import InitErrorDetails

from fairlead.skill.slots import AngleUnit, Slot

MOST_DIMENSIONS = 4096
"""Far beyond any policy's output; a typing error must not be checked index by index for minutes."""


class ActionContract(BaseModel):
    """Size and meaning of an action vector.

    Attributes:
        slots: what each range of the vector commands, or that it is discarded.
        joint_names: instead of slots, the joint whose position each dimension is; any
            order, which dispatch turns into the robot's.
        joint_unit: with ``joint_names``, the unit of the policy's angles; ``rad`` if left out.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    dim: int = Field(gt=0, le=MOST_DIMENSIONS)
    slots: tuple[Slot, ...] = ()
    joint_names: tuple[str, ...] | None = None
    joint_unit: AngleUnit | None = None

    @property
    def routed(self) -> tuple[Slot, ...]:
        """The slots that command something; named joints are one slot each."""
        if self.joint_names is None:
            return tuple(slot for slot in self.slots if not slot.discard)
        return tuple(
            Slot(
                range=(index, index),
                control_mode="joint_position",
                joint_names=(name,),
                unit=self.joint_unit,
            )
            for index, name in enumerate(self.joint_names)
        )

    @model_validator(mode="wrap")
    @classmethod
    def _cover_beside_faults(cls, data: Any, check: ModelWrapValidatorHandler[Self]) -> Self:
        """Gaps and overlaps are told also while a slot has a fault of its own."""
        try:
            return check(data)
        except ValidationError as error:
            details = error.errors()
            if not any(detail["loc"][:1] == ("slots",) for detail in details):
                raise
            found = [cast(InitErrorDetails, detail) for detail in details]
            problems = _cover_problems_of_raw(data)
            if problems:
                told = ValueError("\n".join(problems))
                found.append({"type": "value_error", "ctx": {"error": told}, "input": data})
            raise ValidationError.from_exception_data(error.title, found) from None

    @model_validator(mode="after")
    def _check(self) -> Self:
        problems = (
            _cover_problems(self.dim, self.slots) or _repeat_problems(self.routed)
            if self.joint_names is None
            else _joint_problems(self.dim, self.slots, self.joint_names)
        )
        if self.joint_names is None and self.joint_unit is not None:
            problems.append("joint_unit: only with joint_names; for degrees in a slot: unit: deg")
        if problems:
            raise ValueError("\n".join(problems))
        return self


def _joint_problems(dim: int, slots: tuple[Slot, ...], names: tuple[str, ...]) -> list[str]:
    problems = ["joint_names: not allowed beside slots"] if slots else []
    if len(names) != dim:
        problems.append(f"joint_names: expected {dim}, one per dimension, got {len(names)}")
    problems += [
        f"joint_names: {name!r} is given {count} times"
        for name, count in Counter(names).items()
        if count > 1
    ]
    return problems


class _Extent(NamedTuple):
    """What is covered by a slot that may have faults."""

    first: int
    last: int
    name: str


def _cover_problems_of_raw(data: Any) -> list[str]:
    """As `_cover_problems`, of a block as it stands in the file; [] if it cannot be known."""
    try:
        slots = []
        for slot in data["slots"]:
            first, last = slot["range"]
            name = f"slot [{first}, {last}] {slot.get('control_mode', '')}".rstrip()
            slots.append(_Extent(first, last, name))
        is_known = all(s.first >= 0 for s in slots) and data["dim"] <= MOST_DIMENSIONS
        return _cover_problems(data["dim"], slots) if is_known else []
    except (KeyError, TypeError, ValueError, AttributeError):
        return []


def _cover_problems(dim: int, slots: Sequence[Slot | _Extent]) -> list[str]:
    if not slots:
        return [f"slots: expected every index of 0..{dim - 1} to be covered, got no slots"]
    problems = [
        f"{slot.name}: index {max(slot.first, dim)} is out of range, dim is {dim}"
        for slot in slots
        if slot.last >= dim
    ]
    for index in range(dim):
        owners = [slot.name for slot in slots if slot.first <= index <= slot.last]
        if not owners:
            problems.append(f"slots: index {index} is covered by no slot (use discard: true)")
        elif len(owners) > 1:
            problems.append(f"slots: index {index} is covered by {' and '.join(owners)}")
    return problems


def _repeat_problems(slots: tuple[Slot, ...]) -> list[str]:
    joints = Counter(name for slot in slots for name in slot.joint_names or ())
    targets = Counter((slot.control_mode, slot.ee) for slot in slots if slot.joint_names is None)
    return [
        *(f"slots: joint {name} is commanded by {n} slots" for name, n in joints.items() if n > 1),
        *(
            f"slots: {mode}{f' of {ee}' if ee else ''} is commanded by {n} slots"
            for (mode, ee), n in targets.items()
            if n > 1
        ),
    ]
