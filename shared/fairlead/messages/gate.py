"""What the gate grants, decides and says, and a runner's hold on parts of the robot."""

from __future__ import annotations

from enum import IntEnum

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record


class Decision(IntEnum):
    """The gate's decision on one claim for the lease's tick."""

    UNDECIDED = 0
    ROW = 1  # the row for this tick is released in ``verdict_id``
    HOLD = 2  # the chunk for this tick was refused by ``verdict_id``


class Grant(Record, frozen=True, kw_only=True):
    """One live claim: its rows may run up to and including ``until_tick``."""

    source: str
    claim_id: U64
    until_tick: U64
    decision: U8
    verdict_id: U64


class GateState(IntEnum):
    """States of the gate, in order of severity above DISARMED."""

    BOOT = 0
    DISARMED = 1
    ARMED = 2
    STOPPED = 3
    LATCHED = 4


class Lease(Message, frozen=True, kw_only=True, tag=9):
    """The gate's permission to move; the HAL holds without a fresh one."""

    version: V1 = 1
    session: U64
    epoch: U64
    lease_seq: U64
    config_hash: Hash32
    state: U8
    state_tick: U64
    grants: tuple[Grant, ...]
    stop_ids: tuple[U64, ...]


class Outcome(IntEnum):
    """What happened to a chunk."""

    RELEASED = 0
    TRUNCATED = 1
    REFUSED = 2


class Verdict(Message, frozen=True, kw_only=True, tag=10):
    """The gate's answer to one chunk.

    code: 0, or 1..50 for G001..G050. row: the offending row, -1 if none. part, axis:
    names, "" if none. value, limit, margin (limit minus value, for a lower limit value minus
    limit: negative outside): 0.0 if code is 0. released_first/last: ticks, 0 if nothing was
    released.
    """

    version: V1 = 1
    verdict_id: U64
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    seq: U64
    outcome: U8
    code: U32
    row: int
    part: str
    axis: str
    value: float
    limit: float
    margin: float
    limit_source: str
    released_first: U64
    released_last: U64
    config_hash: Hash32
    latency_ns: U64


class LimitOverride(Record, frozen=True, kw_only=True):
    """A tighter limit for one claim: ``name`` as in the compiled gate file's mode block."""

    part: str
    mode: U8
    name: str
    value: float


class Claim(Message, frozen=True, kw_only=True, tag=27):
    """Ask for a set of parts. Reply: `ClaimReply`."""

    version: V1 = 1
    source: str
    skill: str
    skill_hash: Hash32
    robot_hash: Hash32
    period_ns: U64
    parts: tuple[str, ...]
    chunk_rate_hz: float
    horizon_max: U32
    age_max_ticks: U32
    limits: tuple[LimitOverride, ...]


class ClaimReply(Message, frozen=True, kw_only=True, tag=28):
    """The claim is granted: its id, and the epoch and HAL session that it ends with."""

    version: V1 = 1
    claim_id: U64
    epoch: U64
    session: U64


class Release(Message, frozen=True, kw_only=True, tag=29):
    """Give a claim back. Reply: `Done`."""

    version: V1 = 1
    source: str
    claim_id: U64


class Heartbeat(Message, frozen=True, kw_only=True, tag=13):
    """The runner is alive and still wants its claim."""

    version: V1 = 1
    claim_id: U64


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
