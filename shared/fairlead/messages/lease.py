"""The gate's permission to move."""

from __future__ import annotations

from enum import IntEnum

from fairlead.messages.message import U8, U64, V1, Hash32, Message, Record


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
