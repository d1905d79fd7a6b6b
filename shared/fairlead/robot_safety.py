"""The safety block of a robot manifest: what the gate enforces, per profile.

Units are in the field names; ``joint units`` means rad for turning joints and m for
sliding ones. `fairlead.gate_config` compiles this into the file the gate loads.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Count = Annotated[int, Field(gt=0)]


class _Block(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class MeasuredLimits(_Block):
    """What a joint's *measured* state may do before the gate stops (joint units).

    tolerance: beyond the position limits (joints with position limits only).
    jump_per_tick: change of the measured position within one control period.
    standstill_per_s: speed below which the joint counts as standing still.
    """

    tolerance: Positive | None = None
    jump_per_tick: Positive
    standstill_per_s: Positive
    source: str


class JointPositionMode(_Block):
    """step_limits: largest jump of the setpoint, per joint of the part (joint units)."""

    step_limits: tuple[Positive, ...]
    source: str


class JointVelocityMode(_Block):
    """step_limits: largest change of the velocity from row to row, per joint of the part."""

    step_limits: tuple[Positive, ...]
    source: str


class CartesianDeltaMode(_Block):
    """Norms of one row's translation and rotation vector, and of their change per row."""

    frames: tuple[str, ...] = Field(min_length=1)
    linear_limit_m: Positive
    angular_limit_rad: Positive
    linear_step_limit_m: Positive
    angular_step_limit_rad: Positive
    source: str


class BodyTwistMode(_Block):
    """Norms of a twist; ``free_axes`` are those the base can do, the others must be 0."""

    frames: tuple[str, ...] = Field(min_length=1)
    linear_limit_m_s: Positive
    angular_limit_rad_s: Positive
    linear_step_limit_m_s: Positive
    angular_step_limit_rad_s: Positive
    free_axes: tuple[Annotated[int, Field(ge=0, le=5)], ...] = Field(min_length=1)
    source: str


class GripperPositionMode(_Block):
    """Total opening and its largest change per row."""

    lower_m: Finite
    upper_m: Finite
    step_limit_m: Positive
    source: str

    @model_validator(mode="after")
    def _ordered(self) -> GripperPositionMode:
        if self.lower_m >= self.upper_m:
            raise ValueError(
                f"gripper_position: inverted limits, lower_m {self.lower_m} is not below "
                f"upper_m {self.upper_m}"
            )
        return self


class CompositeMode(_Block):
    """The range is [-1, 1] by definition; ``step_limit`` bounds its change per row."""

    step_limit: Positive
    source: str


class ModeLimits(_Block):
    """Limits of each mode one part supports; an absent mode is refused by the gate."""

    joint_position: JointPositionMode | None = None
    joint_velocity: JointVelocityMode | None = None
    cartesian_delta: CartesianDeltaMode | None = None
    body_twist: BodyTwistMode | None = None
    gripper_position: GripperPositionMode | None = None
    composite_mode: CompositeMode | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The modes that have limits, in mode-number order."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) is not None)


class Protocol(_Block):
    """Windows and rates of the protocol that are the same for every claim."""

    horizon_max: Count
    age_max_ticks: Count
    chunk_rate_max_hz: Positive
    seq_jump_max: Count
    state_timeout_ms: Count
    heartbeat_timeout_realtime_ms: Count
    heartbeat_timeout_lockstep_ms: Count
    lease_interval_ms: Count
    idle_disarm_s: Count
    stops_to_latch: Count
    stop_window_s: Count
    bad_frames_limit: Count
    bad_frames_window_ticks: Count


class SafetyProfile(_Block):
    """Everything the gate enforces in one profile."""

    lockstep_allowed: bool
    measured: dict[str, MeasuredLimits]
    parts: dict[str, ModeLimits]
    protocol: Protocol


ProfileName = Literal["sim", "hardware"]
