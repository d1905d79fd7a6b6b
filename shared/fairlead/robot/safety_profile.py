"""The safety block of a robot manifest: what the gate enforces, per profile.

Units are in the field names; ``joint units`` means rad for turning joints and m for
sliding ones. `fairlead.robot.gate_file` compiles this into the file the gate loads.
"""

from __future__ import annotations

from itertools import permutations
from typing import Annotated, Literal

from pydantic import Field

from fairlead.robot.joint import Joint
from fairlead.robot.mode_limits import ModeLimits, Positive, SafetyBlock
from fairlead.robot.surroundings import BaseSurroundings, SelfCollision, Workspace


class MeasuredLimits(SafetyBlock):
    """What a joint's *measured* state may do before the gate stops (joint units).

    tolerance: beyond the position limits (joints with position limits only).
    jump_per_tick: change of the measured position within one control period.
    standstill_per_s: speed below which the joint counts as standing still.

    Commanded joints only:
    contact_limit: largest measured effort [N m or N].
    encoder_step: a smaller change of the measured position is none.
    dead_band_per_tick: commanded motion up to which the joint need not move, added up since its
        last measured change: the most of one control period, and of any number of slower ones.
    stop_lag_s: for so long it goes on at its speed before it brakes, after rows that tell
        velocities, deltas or twists.
    """

    tolerance: Positive | None = None
    jump_per_tick: Positive
    standstill_per_s: Positive
    contact_limit: Positive | None = None
    encoder_step: Positive | None = None
    dead_band_per_tick: Positive | None = None
    stop_lag_s: Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)] | None = None
    source: str


class TighterJoint(SafetyBlock):
    """Limits of a commanded joint that are tighter in this profile than its own (joint units).

    acceleration_per_s2: braking is predicted from it; if unsure, less.
    """

    velocity_per_s: Positive | None = None
    acceleration_per_s2: Positive | None = None
    effort: Positive | None = None
    source: str


class Protocol(SafetyBlock):
    """Windows and rates of the protocol that are the same for every claim.

    Ranges are the gate's; leases have to come well within the HAL's 75 ms.
    step_deadline_us: ten times a gate step on your machine; of the others, the shipped values.
    """

    horizon_max: Annotated[int, Field(ge=1, le=64)]
    age_max_ticks: Annotated[int, Field(ge=1, le=1000)]
    chunk_rate_max_hz: Annotated[float, Field(ge=0.01, le=50, allow_inf_nan=False)]
    seq_jump_max: Annotated[int, Field(ge=1, le=1_000_000_000)]
    state_timeout_ms: Annotated[int, Field(ge=1, le=10_000)]
    heartbeat_timeout_realtime_ms: Annotated[int, Field(ge=50, le=10_000)]
    heartbeat_timeout_lockstep_ms: Annotated[int, Field(ge=50, le=60_000)]
    lease_interval_ms: Annotated[int, Field(ge=6, le=50)]
    idle_disarm_s: Annotated[int, Field(ge=1, le=86_400)]
    stops_to_latch: Annotated[int, Field(ge=1, le=16)]
    stop_window_s: Annotated[int, Field(ge=1, le=86_400)]
    bad_frames_limit: Annotated[int, Field(ge=1, le=16)]
    bad_frames_window_ticks: Annotated[int, Field(ge=1, le=1000)]
    stuck_ticks: Annotated[int, Field(ge=1, le=1000)]
    stop_ramp_ms: Annotated[int, Field(ge=1, le=60_000)]
    step_deadline_us: Annotated[int, Field(ge=1, le=1_000_000)]
    second_person_s: int | None = Field(
        default=None,
        ge=1,
        le=3600,
        description="a latch is reset by two persons who ask within so many s; none: by one",
    )


class PartSafety(ModeLimits):
    """What one part may be told, and when its mode may change.

    singularity_limit: smallest singular value of the tool's Jacobian that cartesian modes may
        go down to, and begin at half of; exactly the parts with such a mode have one. Choose half
        of the smallest in good work.
    transitions: pairs of modes, from and to, that may follow each other at standstill; ``any``
        stands for all pairs of the part's modes.
    """

    singularity_limit: Positive | None = None
    transitions: Literal["any"] | tuple[tuple[str, str], ...]

    @property
    def mode_changes(self) -> tuple[tuple[str, str], ...]:
        """The pairs, ``any`` written out in mode-number order."""
        if self.transitions != "any":
            return self.transitions
        return tuple(permutations(self.names, 2))


class SafetyProfile(SafetyBlock):
    """Everything the gate enforces in one profile; ``base`` for robots with zones only."""

    lockstep_allowed: bool
    tighter_joints: dict[str, TighterJoint] = Field(default_factory=dict)
    measured: dict[str, MeasuredLimits]
    parts: dict[str, PartSafety]
    self_collision: SelfCollision
    workspace: Workspace
    base: BaseSurroundings | None = None
    protocol: Protocol


ProfileName = Literal["sim", "hardware"]


def profile_limits(joint: Joint, safety: SafetyProfile) -> tuple[float, float, float, str]:
    """Velocity, acceleration and effort limit of a commanded joint in a profile, and the source."""
    own = (joint.velocity_limit, joint.acceleration_limit, joint.effort_limit)
    tighter = safety.tighter_joints.get(joint.name)
    if tighter is None:
        return (*own, joint.source)
    given = (tighter.velocity_per_s, tighter.acceleration_per_s2, tighter.effort)
    velocity, acceleration, effort = (
        mine if less is None else less for mine, less in zip(own, given, strict=True)
    )
    nothing_own = not joint.has_bounds and None not in given
    source = tighter.source if nothing_own else f"{tighter.source}; {joint.source}"
    return velocity, acceleration, effort, source


def outside_limits(joint: Joint, safety: SafetyProfile, position: float) -> str:
    """How far off a measured position is [rad or m], "" within the limits and their tolerance."""
    beyond = safety.measured[joint.name].tolerance or 0.0
    if not joint.has_bounds or joint.lower - beyond <= position <= joint.upper + beyond:
        return ""
    return f"{joint.name}: {position:.3g} {joint.unit}, declared {joint.lower:g} to {joint.upper:g}"
