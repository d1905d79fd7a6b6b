"""What the robot is, what it measured in one tick, and the state vector made of it."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record


class Hold(IntEnum):
    """Why a part held instead of executing a released row. 0 means it executed one."""

    NONE = 0
    NO_CLAIM = 1  # no released chunk addresses the part
    NO_ROW = 2  # the released rows have run out
    NOT_GRANTED = 3  # the newest lease does not grant the claim for this tick
    LEASE_STALE = 4  # no lease within 75 ms, or the HAL itself was paused
    STOPPED = 5  # a stop is held
    REFUSED = 6  # lockstep: the gate refused the chunk for this tick
    RESETTING = 7  # a reset_episode is running
    SUPERSEDED = 8  # the chunk did not continue what was executed; dropped whole
    STARTING = 9  # nothing has been received yet


class Acted(Record, frozen=True, kw_only=True):
    """What one part did in a tick: row ``row`` of verdict ``verdict_id``, or a hold."""

    hold: U8
    verdict_id: U64
    row: U32


HELD = Acted(hold=Hold.STARTING, verdict_id=0, row=0)
"""What a part did before the first tick: it held."""


class JointState(Message, frozen=True, kw_only=True, tag=1):
    """Measured state at the start of period ``tick``.

    positions, velocities, efforts: float64 blocks over the robot's commanded joints in
    wire order, then its passive joints; rad or m, rad/s or m/s, N m or N.
    acted: per part in robot order, what the part did in period ``tick - 1``.
    """

    version: V1 = 1
    session: U64
    tick: U64
    episode_tick: U64
    stamp_ns: U64  # HAL monotonic clock, for display only
    positions: bytes
    velocities: bytes
    efforts: bytes
    acted: tuple[Acted, ...]
    robot_hash: Hash32


class Transform(Record, frozen=True, kw_only=True):
    """Pose of frame ``child`` in frame ``parent``: T_parent_child."""

    parent: str
    child: str
    translation: bytes  # 3 float64 [m]
    rotation_xyzw: bytes  # 4 float64


class TransformBatch(Message, frozen=True, kw_only=True, tag=2):
    """Transforms measured at one tick (static ones are repeated at 1 Hz)."""

    version: V1 = 1
    session: U64
    tick: U64
    is_static: bool
    transforms: tuple[Transform, ...]


class Image(Message, frozen=True, kw_only=True, tag=3):
    """One camera frame; row 0 is the top of the picture."""

    version: V1 = 1
    session: U64
    tick: U64
    camera: str
    width: U32
    height: U32
    encoding_name: Literal["rgb8", "jpeg", "depth32f"]
    data: bytes


class TaskState(Message, frozen=True, kw_only=True, tag=4):
    """A simulator's own success check at the start of period ``tick``."""

    version: V1 = 1
    session: U64
    tick: U64
    episode_tick: U64
    success: bool
    metrics: tuple[tuple[str, float], ...]


class ModeRange(Record, frozen=True, kw_only=True):
    """SI command range of one mode of one part, one float64 per controlled value."""

    mode: U8
    lower: bytes
    upper: bytes


class HalPart(Record, frozen=True, kw_only=True):
    """One part as the HAL found it. ``simulator_part`` is "" on hardware."""

    name: str
    simulator_part: str
    joints: tuple[str, ...]
    ranges: tuple[ModeRange, ...]


class HalCamera(Record, frozen=True, kw_only=True):
    """One camera and how many ticks lie between its frames."""

    name: str
    width: U32
    height: U32
    period_ticks: U32


class HalStatus(Message, frozen=True, kw_only=True, tag=5):
    """Who the robot is and how it is paced."""

    version: V1 = 1
    session: U64
    robot: str
    robot_hash: Hash32
    pacing: Literal["realtime", "lockstep"]
    period_ns: U64
    tick: U64
    episode_tick: U64
    state: Literal["ready", "resetting", "holding", "fault"]
    detail: str
    joints: tuple[str, ...]
    passive_joints: tuple[str, ...]
    parts: tuple[HalPart, ...]
    simulator_order: tuple[str, ...]
    cameras: tuple[HalCamera, ...]
    has_task: bool
    overruns: U64


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
