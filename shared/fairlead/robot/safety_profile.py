"""The safety block of a robot manifest: what the gate enforces, per profile.

Units are in the field names; ``joint units`` means rad for turning joints and m for
sliding ones. `fairlead.robot.gate_file` compiles this into the file the gate loads.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from fairlead.robot.mode_limits import ModeLimits, Positive, SafetyBlock

Count = Annotated[int, Field(gt=0)]


class MeasuredLimits(SafetyBlock):
    """What a joint's *measured* state may do before the gate stops (joint units).

    tolerance: beyond the position limits (joints with position limits only).
    jump_per_tick: change of the measured position within one control period.
    standstill_per_s: speed below which the joint counts as standing still.
    """

    tolerance: Positive | None = None
    jump_per_tick: Positive
    standstill_per_s: Positive
    source: str


class Protocol(SafetyBlock):
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


class SafetyProfile(SafetyBlock):
    """Everything the gate enforces in one profile."""

    lockstep_allowed: bool
    measured: dict[str, MeasuredLimits]
    parts: dict[str, ModeLimits]
    protocol: Protocol


ProfileName = Literal["sim", "hardware"]
