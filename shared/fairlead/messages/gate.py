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
    until_tick: U64  # last tick its rows may run
    decision: U8  # on state_tick: 0 undecided, 1 row, 2 hold
    verdict_id: U64  # that decided, 0: none


class GateState(IntEnum):
    """States of the gate, in order of severity above DISARMED."""

    BOOT = 0
    DISARMED = 1
    ARMED = 2
    STOPPED = 3
    LATCHED = 4


class Lease(Message, frozen=True, kw_only=True, tag=9):
    """`safety/lease`: the gate's permission to move; the HAL holds without a fresh one."""

    version: V1 = 1
    session: U64
    epoch: U64
    lease_seq: U64  # from 1 in each epoch
    config_hash: Hash32
    state: U8  # of the gate
    state_tick: U64  # newest joint state
    grants: tuple[Grant, ...]  # one per live claim
    stop_ids: tuple[U64, ...]  # stops held now


class Outcome(IntEnum):
    """What happened to a chunk."""

    RELEASED = 0
    TRUNCATED = 1
    REFUSED = 2


class Verdict(Message, frozen=True, kw_only=True, tag=10):
    """`safety/verdict/<source>`: the gate's answer to one chunk.

    value, limit and margin are 0.0 if code is 0.
    """

    version: V1 = 1
    verdict_id: U64  # random start per gate process, then rising
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    seq: U64  # the chunk answered
    outcome: U8  # 0 released, 1 truncated, 2 refused
    code: U32  # 0, or 1 to 50 for G001 to G050
    row: int  # at fault, -1: none
    part: str  # at fault, or empty
    axis: str  # its joint or axis, or empty
    value: float  # what was asked
    limit: float  # what is allowed
    margin: float  # limit minus value (lower limit: value minus limit), 0 of a rule
    limit_source: str  # where the limit is declared; of a rule, what it needs
    released_first: U64  # tick, 0: none
    released_last: U64  # tick, 0: none
    config_hash: Hash32
    latency_ns: U64  # ns from receipt to verdict, the gate's own clock
    unit: str = ""  # of value, limit and margin, "1": a plain number; empty: a rule; may be absent


class LimitOverride(Record, frozen=True, kw_only=True):
    """A tighter limit for one claim."""

    part: str  # name
    mode: U8
    name: str  # as in the gate's configuration
    value: float  # SI


class Claim(Message, frozen=True, kw_only=True, tag=27):
    """Query `safety/cmd/claim/<source>`: ask for a set of parts. Reply: `ClaimReply`."""

    version: V1 = 1
    source: str
    skill: str
    skill_hash: Hash32
    robot_hash: Hash32
    period_ns: U64  # ns, the sender's tick
    parts: tuple[str, ...]  # names
    chunk_rate_hz: float  # chunks per second, at most
    horizon_max: U32  # rows per chunk, at most
    age_max_ticks: U32  # from the oldest input to receipt, at most
    limits: tuple[LimitOverride, ...]  # tighter ones; looser are refused
    by: str = ""  # who asks; may be absent


class ClaimReply(Message, frozen=True, kw_only=True, tag=28):
    """The claim is granted: its id, and the epoch and HAL session that it ends with."""

    version: V1 = 1
    claim_id: U64
    epoch: U64
    session: U64


class Release(Message, frozen=True, kw_only=True, tag=29):
    """Query `safety/cmd/release/<source>`: give a claim back, or offer it. Reply: `Done`."""

    version: V1 = 1
    source: str
    claim_id: U64
    offered_to: str = ""  # whose next claim of the same parts goes on with its rows; may be absent


class Heartbeat(Message, frozen=True, kw_only=True, tag=13):
    """`skill/<source>/heartbeat`: the runner is alive and still wants its claim."""

    version: V1 = 1
    claim_id: U64


class ClaimInfo(Record, frozen=True, kw_only=True):
    """One live claim as the gate lists it."""

    source: str
    skill: str
    claim_id: U64
    parts: tuple[str, ...]  # names


class GateStatus(Message, frozen=True, kw_only=True, tag=11):
    """`safety/status`: what the gate is doing and why."""

    version: V1 = 1
    robot: str
    profile: str  # sim or hardware
    session: U64  # that the gate follows, 0: none
    epoch: U64
    state: U8  # of the gate
    cause: str  # why, in words
    fix: str  # the command that would change it
    latch_id: U64  # to reset, 0: not latched
    stop_ids: tuple[U64, ...]  # to reset
    claims: tuple[ClaimInfo, ...]
    counters: tuple[tuple[str, U64], ...]  # released, truncated, and each code
    state_tick: U64  # newest joint state
    lockstep_allowed: bool
    config_hash: Hash32
    robot_hash: Hash32
