"""What the gate is doing and why."""

from __future__ import annotations

from fairlead.messages.message import U8, U64, V1, Hash32, Message, Record


class ClaimInfo(Record, frozen=True, kw_only=True):
    """One live claim as the gate lists it."""

    source: str
    skill: str
    claim_id: U64
    parts: tuple[str, ...]


class GateStatus(Message, frozen=True, kw_only=True, tag=11):
    """What the gate is doing and why. ``fix`` is the command that would change it."""

    version: V1 = 1
    robot: str
    profile: str
    session: U64  # the HAL's session the gate follows, 0 if none
    epoch: U64
    state: U8
    cause: str
    fix: str
    latch_id: U64
    stop_ids: tuple[U64, ...]
    claims: tuple[ClaimInfo, ...]
    counters: tuple[tuple[str, U64], ...]  # ("released", n), ("G020", n), ...
    state_tick: U64
    lockstep_allowed: bool
    config_hash: Hash32
    robot_hash: Hash32
