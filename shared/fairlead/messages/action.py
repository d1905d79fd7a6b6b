"""Commands on their way to the robot: proposed by a runner, released by the gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record
from fairlead.messages.state import Acted

Trace = Annotated[bytes, msgspec.Meta(min_length=24, max_length=24)]


class ActionPart(Record, frozen=True, kw_only=True):
    """Commands of one part for every row of a chunk."""

    part: U8  # index into the robot's parts
    mode: U8
    frame_id: str  # empty where the mode has none
    values: bytes  # horizon rows of the mode's width
    active: tuple[U8, ...]  # joint modes: indices of the joints commanded, rising


class ActionChunk(Message, frozen=True, kw_only=True, tag=7):
    """`action/candidate/<source>`: a proposal; row k is meant for tick ``start_tick + k``."""

    version: V1 = 1
    robot_hash: Hash32
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    seq: U64  # from 1, one higher per chunk of the claim
    goal_id: U64
    obs_tick: U64  # joint state it was computed from
    oldest_tick: U64
    start_tick: U64  # row k is for tick start_tick + k
    horizon: U32  # rows, 1 to 64
    parts: tuple[ActionPart, ...]  # released or refused together
    trace: Trace  # W3C trace id (16 bytes), span id (8), or zeros


class SafeChunk(Message, frozen=True, kw_only=True, tag=8):
    """`action/safe/<source>`: rows the gate released; row k is for tick ``first_tick + k``."""

    version: V1 = 1
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    verdict_id: U64  # the verdict that released it
    judged_tick: U64  # newest state it was judged against
    first_tick: U64  # row k is for tick first_tick + k
    horizon: U32  # rows
    after: Acted  # what the claim must have done in tick first_tick - 1
    parts: tuple[ActionPart, ...]  # encoded anew by the gate
