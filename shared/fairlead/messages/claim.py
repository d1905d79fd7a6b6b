"""A runner's hold on parts of the robot: asked for, kept alive, given back."""

from __future__ import annotations

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record


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
