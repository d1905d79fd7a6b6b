"""The policy's state vector, or why there is none."""

from __future__ import annotations

from fairlead.messages.message import U64, V1, Hash32, Message, Record


class LayoutFault(Record, frozen=True, kw_only=True):
    """Why a layout vector could not be assembled (see `fairlead.errors.LayoutError`)."""

    kind: str
    name: str
    parent: str
    age_ticks: int
    text: str


class LayoutState(Message, frozen=True, kw_only=True, tag=6):
    """The policy's state vector at ``tick``: either ``values`` or ``fault``, never both."""

    version: V1 = 1
    session: U64
    tick: U64
    episode_tick: U64
    oldest_tick: U64
    skill: str
    skill_hash: Hash32
    layout: str
    values: bytes | None
    fault: LayoutFault | None

    def __post_init__(self) -> None:
        if (self.values is None) == (self.fault is None):
            raise ValueError("exactly one of values and fault must be set")
