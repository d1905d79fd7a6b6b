"""The gate's answer to one chunk."""

from __future__ import annotations

from enum import IntEnum

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message


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
