"""Commands on their way to the robot: proposed by a runner, released by the gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record
from fairlead.messages.state import Acted


class ActionPart(Record, frozen=True, kw_only=True):
    """Commands of one part for every row of a chunk.

    part: index into the robot's parts. mode: `fairlead.modes.ControlMode`.
    frame_id: "" where the mode has no frame. values: float64 ``[horizon, width]``.
    active: joint modes only, indices of the joints commanded, ascending.
    """

    part: U8
    mode: U8
    frame_id: str
    values: bytes
    active: tuple[U8, ...]


class ActionChunk(Message, frozen=True, kw_only=True, tag=7):
    """A candidate: row k is meant for tick ``start_tick + k``.

    obs_tick: tick of the joint state it was computed from. oldest_tick: its oldest
    non-static input. trace: W3C trace id (16 bytes) and span id (8 bytes), or zeros.
    """

    version: V1 = 1
    robot_hash: Hash32
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    seq: U64
    goal_id: U64
    obs_tick: U64
    oldest_tick: U64
    start_tick: U64
    horizon: U32
    parts: tuple[ActionPart, ...]
    trace: Annotated[bytes, msgspec.Meta(min_length=24, max_length=24)]


class SafeChunk(Message, frozen=True, kw_only=True, tag=8):
    """Rows the gate released; row k is for tick ``first_tick + k``.

    after: what the gate takes the claim's parts to do in tick ``first_tick - 1``.
    """

    version: V1 = 1
    session: U64
    epoch: U64
    claim_id: U64
    source: str
    verdict_id: U64
    judged_tick: U64
    first_tick: U64
    horizon: U32
    after: Acted
    parts: tuple[ActionPart, ...]
