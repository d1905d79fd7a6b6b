"""Slots: what each dimension of a policy's flat action vector means.

A slot covers an inclusive index range ``[first, last]`` and either routes it to one
control mode of the robot or discards it on purpose.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import Any, Literal, NamedTuple, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.modes import ControlMode
from fairlead.skill.scales import Numbers, scale_problems, spread


class FieldRule(NamedTuple):
    """Which of ee, frame, joint_names, axes, unit a mode needs, and which it may have."""

    required: tuple[str, ...]
    optional: tuple[str, ...] = ()


AngleUnit = Literal["rad", "deg"]
_RADIANS: dict[AngleUnit, float] = {"rad": 1.0, "deg": math.pi / 180.0}

_CARTESIAN = FieldRule(required=("ee", "frame"))
_ANGLE = FieldRule(required=("joint_names",), optional=("unit",))
_GRIPPER = FieldRule(required=("ee",))

FIELD_RULES: dict[ControlMode, FieldRule] = {
    ControlMode.CARTESIAN_POSE: _CARTESIAN,
    ControlMode.CARTESIAN_DELTA: FieldRule(required=("ee", "frame"), optional=("axes",)),
    ControlMode.CARTESIAN_TWIST: _CARTESIAN,
    ControlMode.JOINT_POSITION: _ANGLE,
    ControlMode.JOINT_VELOCITY: _ANGLE,
    ControlMode.DEX_HAND_JOINT: _ANGLE,
    ControlMode.GRIPPER_BINARY: _GRIPPER,
    ControlMode.GRIPPER_POSITION: _GRIPPER,
    ControlMode.BODY_TWIST: FieldRule(required=(), optional=("axes",)),
    ControlMode.COMPOSITE_MODE: FieldRule(required=()),
}
"""Field table per mode; a mode that is not in it cannot be routed to."""

MODE_NAMES: tuple[str, ...] = tuple(mode.yaml_name for mode in FIELD_RULES)
_TWO_ENDS = (
    ControlMode.GRIPPER_BINARY,
    ControlMode.GRIPPER_POSITION,
    ControlMode.COMPOSITE_MODE,
)
"""Modes whose one number may be decided by a threshold."""
_SOURCE_FIELDS = ("ee", "frame", "joint_names", "axes", "unit")


class Slot(BaseModel):
    """One inclusive range of the action vector and where it goes.

    Attributes:
        range: first and last index, both included.
        control_mode: the mode's name, for example ``cartesian_delta``; None if discarded.
        discard: True for a range that is dropped on purpose.
        ee: end effector of a cartesian or gripper mode.
        frame: frame the cartesian axes belong to.
        joint_names: joints of a joint mode, one per dimension, in the policy's order.
        axes: body_twist or cartesian_delta narrower than 6: which of x y z rx ry rz each
            dimension is. A twist is 0 along the others; a delta leaves them to the arm: they get
            the tool's motion that comes with the least motion of its joints.
        unit: of the policy's angles, ``deg`` for degrees or degrees per second; SI without it.
        scale, offset: value in the slot's unit = scale * output + offset; one number, or one per
            dimension.
        clip: lowest and highest number, before scale and offset; what is beyond becomes the
            nearer of them. Without it values go out as they are, for the gate to refuse.
        threshold: gripper_binary: a value, after scale and offset, of at least this is 1
            (closed), a smaller one 0 (open); without it the gate refuses all but 0 and 1.
            gripper_position and composite_mode: a number of at least this becomes 1, a smaller
            one -1, before scale and offset.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    range: tuple[int, int]
    control_mode: str | None = None
    discard: bool = False
    ee: str | None = None
    frame: str | None = None
    joint_names: tuple[str, ...] | None = None
    axes: tuple[int, ...] | None = None
    unit: AngleUnit | None = None
    scale: Numbers | None = None
    offset: Numbers | None = None
    clip: tuple[float, float] | None = None
    threshold: float | None = Field(default=None, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _no_unit(cls, data: Any) -> Any:
        if isinstance(data, dict) and "joint_unit" in data:
            raise ValueError("joint_unit: not in a slot; for degrees write unit: deg")
        return data

    @property
    def first(self) -> int:
        """Index of the slot's first number in the policy's vector."""
        return self.range[0]

    @property
    def last(self) -> int:
        """Index of the slot's last number in the policy's vector, included."""
        return self.range[1]

    @property
    def width(self) -> int:
        """Dimensions covered: ``last - first + 1``."""
        return self.last - self.first + 1

    @property
    def mode(self) -> ControlMode | None:
        """The control mode; None if discarded."""
        return None if self.control_mode is None else ControlMode[self.control_mode.upper()]

    @property
    def name(self) -> str:
        """How errors call this slot, for example ``slot [0, 5] cartesian_delta``."""
        what = self.control_mode or ("discard" if self.discard else "")
        return f"slot [{self.first}, {self.last}] {what}".rstrip()

    def scales(self) -> tuple[float, ...]:
        """What each dimension's number is multiplied by to be SI."""
        return self._in_si(spread(self.scale, 1.0, self.width))

    def offsets(self) -> tuple[float, ...]:
        """What is added to each dimension then, in SI."""
        return self._in_si(spread(self.offset, 0.0, self.width))

    def in_units(self) -> tuple[bool, ...]:
        """Per dimension, whether the policy says the unit's own numbers, not a share of a range."""
        scales = spread(self.scale, 1.0, self.width)
        offsets = spread(self.offset, 0.0, self.width)
        return tuple(pair == (1.0, 0.0) for pair in zip(scales, offsets, strict=True))

    def _in_si(self, values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(value * _RADIANS[self.unit or "rad"] for value in values)

    @model_validator(mode="after")
    def _check(self) -> Self:
        problems = _range_problems(self) or _target_problems(self)
        if problems:
            raise ValueError("\n".join(f"{self.name}: {problem}" for problem in problems))
        return self


def _range_problems(slot: Slot) -> list[str]:
    if slot.first < 0 or slot.last < slot.first:
        return [f"range: expected 0 <= first <= last, got [{slot.first}, {slot.last}]"]
    if slot.discard:
        return []
    if slot.control_mode not in MODE_NAMES:
        got = repr(slot.control_mode) if slot.control_mode else "neither"
        return [
            f"expected control_mode or discard: true, got {got} (valid: {', '.join(MODE_NAMES)})"
        ]
    return []


def _target_problems(slot: Slot) -> list[str]:
    if slot.discard:
        extra = ("control_mode", *_SOURCE_FIELDS, "scale", "offset", "clip", "threshold")
        given = [name for name in extra if getattr(slot, name) is not None]
        return [f"{name}: not allowed with discard" for name in given]
    return [
        *_field_problems(slot),
        *_width_problems(slot),
        *scale_problems({"scale": slot.scale, "offset": slot.offset}, slot.width),
        *_clip_problems(slot),
    ]


def _field_problems(slot: Slot) -> list[str]:
    assert slot.mode is not None
    rule = FIELD_RULES[slot.mode]
    missing = [name for name in rule.required if not getattr(slot, name)]
    allowed = (*rule.required, *rule.optional)
    surplus = [
        name for name in _SOURCE_FIELDS if name not in allowed and getattr(slot, name) is not None
    ]
    if slot.threshold is not None and slot.mode not in _TWO_ENDS:
        surplus.append("threshold")
    return [
        *(f"{name}: required with {slot.control_mode}" for name in missing),
        *(f"{name}: not allowed with {slot.control_mode}" for name in surplus),
    ]


def _width_problems(slot: Slot) -> list[str]:
    assert slot.mode is not None
    if slot.mode.is_joint_mode:
        return _name_problems(slot)
    may_have_axes = "axes" in FIELD_RULES[slot.mode].optional
    if may_have_axes and slot.axes is not None:
        return _axes_problems(slot)
    wanted = slot.mode.width(0)
    if slot.width != wanted:
        hint = ", or axes" if may_have_axes else ""
        return [f"width: expected {wanted} dimension(s){hint}, got {slot.width}"]
    return []


def _name_problems(slot: Slot) -> list[str]:
    names = slot.joint_names or ()
    problems = []
    if names and slot.width != len(names):
        problems.append(
            f"width: expected {len(names)} dimension(s), one per joint name, got {slot.width}"
        )
    problems += [
        f"joint_names: {n} is given twice" for n, count in Counter(names).items() if count > 1
    ]
    return problems


def _axes_problems(slot: Slot) -> list[str]:
    axes = slot.axes or ()
    if list(axes) != sorted(set(axes)) or not axes or not set(axes) <= set(range(6)):
        return [f"axes: expected ascending indices out of 0..5, got {list(axes)}"]
    if len(axes) != slot.width:
        return [f"width: expected {len(axes)} dimension(s), one per axis, got {slot.width}"]
    return []


def _clip_problems(slot: Slot) -> list[str]:
    if slot.clip is None:
        return []
    low, high = slot.clip
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        return [f"clip: expected a lower and a higher finite number, got {list(slot.clip)}"]
    if slot.threshold is not None:
        return ["clip: not beside threshold, which decides already"]
    return []
