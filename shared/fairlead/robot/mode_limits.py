"""What one part may be told, mode by mode: the blocks under ``safety.<profile>.parts``.

Units are in the field names; *joint units* means rad for turning joints and m for sliding
ones. Every block names the source of its numbers. For step limits and norms choose the largest
step that the controller follows without a jerk.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from fairlead.errors import expected

MOST = 1e6
"""As the gate takes for a command; a limit beyond it is none."""
MOST_M = 100.0
"""Of a point in space along an axis: what is more was meant in mm."""
Positive = Annotated[float, Field(gt=0, le=MOST, allow_inf_nan=False)]
Finite = Annotated[float, Field(ge=-MOST, le=MOST, allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=-MOST_M, le=MOST_M, allow_inf_nan=False)]
Point = tuple[Metres, Metres, Metres]
LEAST_GAIN, MOST_GAIN = 0.1, 1.5


def _ordered_gain(gain: tuple[float, float]) -> tuple[float, float]:
    lower, upper = gain
    if 0.0 <= lower <= upper <= MOST_GAIN and upper >= LEAST_GAIN:
        return gain
    wanted = f"0 <= lower <= upper, and upper from {LEAST_GAIN} to {MOST_GAIN}"
    raise ValueError(expected("gain", wanted, str(list(gain))))


def require_source(source: str) -> str:
    """``source``, if it says anything."""
    if not source.strip():
        raise ValueError(f"expected where the numbers come from, in words, got {source!r}")
    return source


Gain = Annotated[tuple[Finite, Finite], AfterValidator(_ordered_gain)]
"""Which share of the motion a row asks for happens within its tick, from the least to the most."""


class SafetyBlock(BaseModel):
    """A block of the safety section: nothing unknown in it, nothing changed later."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("source", check_fields=False)
    @classmethod
    def _says_where_from(cls, source: str) -> str:
        return require_source(source)


class JointPositionMode(SafetyBlock):
    """step_limits: largest jump of the setpoint, per joint of the part (joint units).

    tracking_limits: how far a joint may be from the targets that acted (joint units).
    """

    step_limits: tuple[Positive, ...]
    tracking_limits: tuple[Positive, ...]
    source: str


class JointVelocityMode(SafetyBlock):
    """step_limits: largest change of the velocity from row to row, per joint of the part.

    tracking_limits: how far a joint's velocity may be from those that acted, beyond ``gain``.
    """

    step_limits: tuple[Positive, ...]
    gain: Gain
    tracking_limits: tuple[Positive, ...]
    source: str


class DexHandJointMode(SafetyBlock):
    """As for ``joint_position``, for the joints of a hand (joint units)."""

    step_limits: tuple[Positive, ...]
    tracking_limits: tuple[Positive, ...]
    source: str


class CartesianPoseMode(SafetyBlock):
    """A box for the tool frame's origin, in the frame the pose is given in, and its steps.

    frames: links of the description that a pose may be given in.
    angular_step_limit_rad: angle of the rotation from one row to the next.
    linear_tracking_m, angular_tracking_rad: how far the tool may be from the poses that acted.
    """

    frames: tuple[str, ...] = Field(min_length=1)
    lower_m: Point
    upper_m: Point
    linear_step_limit_m: Positive
    angular_step_limit_rad: Positive
    linear_tracking_m: Positive
    angular_tracking_rad: Positive
    source: str

    @model_validator(mode="after")
    def _ordered(self) -> CartesianPoseMode:
        for axis, lower, upper in zip("xyz", self.lower_m, self.upper_m, strict=True):
            if lower >= upper:
                raise ValueError(
                    f"cartesian_pose: inverted limits along {axis}, lower_m {lower} is not "
                    f"below upper_m {upper}"
                )
        return self


class CartesianDeltaMode(SafetyBlock):
    """Norms of one row's translation and rotation vector, and of their change per row.

    Tracking is how far the tool's motion within a tick may be from ``gain`` times the row's.
    """

    frames: tuple[str, ...] = Field(min_length=1)
    linear_limit_m: Positive
    angular_limit_rad: Positive
    linear_step_limit_m: Positive
    angular_step_limit_rad: Positive
    gain: Gain
    linear_tracking_m: Positive
    angular_tracking_rad: Positive
    source: str


class CartesianTwistMode(SafetyBlock):
    """Norms of the tool frame's linear and angular velocity, and of their change per row.

    Tracking is how far the tool's velocity may be from ``gain`` times the row's.
    """

    frames: tuple[str, ...] = Field(min_length=1)
    linear_limit_m_s: Positive
    angular_limit_rad_s: Positive
    linear_step_limit_m_s: Positive
    angular_step_limit_rad_s: Positive
    gain: Gain
    linear_tracking_m_s: Positive
    angular_tracking_rad_s: Positive
    source: str


class BodyTwistMode(SafetyBlock):
    """Norms of a twist; ``free_axes`` are those the base can do, the others must be 0."""

    frames: tuple[str, ...] = Field(min_length=1)
    linear_limit_m_s: Positive
    angular_limit_rad_s: Positive
    linear_step_limit_m_s: Positive
    angular_step_limit_rad_s: Positive
    gain: Gain
    linear_tracking_m_s: Positive
    angular_tracking_rad_s: Positive
    free_axes: tuple[Annotated[int, Field(ge=0, le=5)], ...] = Field(min_length=1)
    source: str


class GripperBinaryMode(SafetyBlock):
    """Open (0) or closed (1), nothing between; every switch is legal."""

    source: str


class GripperPositionMode(SafetyBlock):
    """What a gripper's joint is told, from end to end, and its largest change per row.

    All in m for a joint that slides (its total opening), all in rad for one that turns.

    slip_limit: how far a gripper may go on that holds something; null declares that losing an
    object is no stop.
    """

    lower_m: Finite | None = None
    upper_m: Finite | None = None
    step_limit_m: Positive | None = None
    slip_limit_m: Positive | None = None
    lower_rad: Finite | None = None
    upper_rad: Finite | None = None
    step_limit_rad: Positive | None = None
    slip_limit_rad: Positive | None = None
    source: str

    @model_validator(mode="after")
    def _is_complete(self) -> GripperPositionMode:
        unit, other = self.unit, {"m": "rad", "rad": "m"}[self.unit]
        needed = [f"{name}_{unit}" for name in ("lower", "upper", "step_limit")]
        missing = [name for name in needed if getattr(self, name) is None]
        if f"slip_limit_{unit}" not in self.model_fields_set:
            missing.append(f"slip_limit_{unit}")
        if missing:
            raise ValueError(f"gripper_position: missing {', '.join(missing)}")
        mixed = [f"{name}_{other}" for name in ("lower", "upper", "step_limit", "slip_limit")]
        mixed = [name for name in mixed if getattr(self, name) is not None]
        if mixed:
            raise ValueError(f"gripper_position: {', '.join(mixed)} beside lower_{unit}")
        if self.lower >= self.upper:
            raise ValueError(
                f"gripper_position: inverted limits, lower_{unit} {self.lower} is not below "
                f"upper_{unit} {self.upper}"
            )
        return self

    @model_serializer(mode="wrap")
    def _in_its_unit(self, dump: SerializerFunctionWrapHandler) -> dict[str, object]:
        told: dict[str, object] = dump(self)
        return {k: v for k, v in told.items() if k == "source" or k.endswith(f"_{self.unit}")}

    @property
    def unit(self) -> str:
        """``m`` or ``rad``."""
        return "m" if self.lower_rad is None else "rad"

    @property
    def lower(self) -> float:
        """Lower end [m or rad]."""
        return float(getattr(self, f"lower_{self.unit}"))

    @property
    def upper(self) -> float:
        """Upper end [m or rad]."""
        return float(getattr(self, f"upper_{self.unit}"))

    @property
    def step_limit(self) -> float:
        """Largest change per row [m or rad]."""
        return float(getattr(self, f"step_limit_{self.unit}"))


class CompositeMode(SafetyBlock):
    """The range is [-1, 1] by definition; ``step_limit`` bounds its change per row.

    switching: where the sign may change.
    """

    step_limit: Positive
    switching: Literal["anywhere", "at_standstill"]
    source: str


class ModeLimits(SafetyBlock):
    """Limits of each mode one part supports; an absent mode is refused by the gate."""

    joint_position: JointPositionMode | None = None
    joint_velocity: JointVelocityMode | None = None
    cartesian_pose: CartesianPoseMode | None = None
    cartesian_delta: CartesianDeltaMode | None = None
    cartesian_twist: CartesianTwistMode | None = None
    body_twist: BodyTwistMode | None = None
    gripper_binary: GripperBinaryMode | None = None
    gripper_position: GripperPositionMode | None = None
    dex_hand_joint: DexHandJointMode | None = None
    composite_mode: CompositeMode | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The modes that have limits, in mode-number order."""
        return tuple(name for name in ModeLimits.model_fields if getattr(self, name) is not None)
