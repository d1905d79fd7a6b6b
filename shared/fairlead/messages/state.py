"""What the robot is, what it measured in one tick, and the state vector made of it."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal

from fairlead.messages.message import U8, U32, U64, V1, Bytes, Hash32, Message, Record


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

    hold: U8  # 0: it executed a row, else why it held
    verdict_id: U64  # 0: it held
    row: U32  # of that verdict's SafeChunk


HELD = Acted(hold=Hold.STARTING, verdict_id=0, row=0)
"""What a part did before the first tick: it held."""


class JointState(Message, frozen=True, kw_only=True, tag=1):
    """`state/joints`: measured at the start of period ``tick``."""

    version: V1 = 1
    session: U64
    tick: U64  # state at the start of this period
    episode_tick: U64
    stamp_ns: U64  # ns, the HAL's monotonic clock, for display only
    positions: bytes  # commanded joints, then passive: rad or m
    velocities: bytes  # rad/s or m/s
    efforts: bytes  # N m or N
    acted: tuple[Acted, ...]  # per part, in the robot's order: what it did in period tick - 1
    robot_hash: Hash32


class Transform(Record, frozen=True, kw_only=True):
    """Pose of frame ``child`` in frame ``parent``: T_parent_child."""

    parent: str  # frame
    child: str  # frame
    translation: bytes  # 3 numbers, m: origin of child in parent
    rotation_xyzw: bytes  # 4 numbers: child to parent


class TransformBatch(Message, frozen=True, kw_only=True, tag=2):
    """`tf/<publisher>`: transforms measured at one tick; static ones are repeated at 1 Hz."""

    version: V1 = 1
    session: U64
    tick: U64
    is_static: bool  # true: valid for the whole episode
    transforms: tuple[Transform, ...]


class Image(Message, frozen=True, kw_only=True, tag=3):
    """`camera/<name>`: one frame."""

    version: V1 = 1
    session: U64
    tick: U64
    camera: str  # its name
    width: U32  # pixels
    height: U32  # pixels
    encoding_name: Literal["rgb8", "jpeg", "depth32f"]  # depth32f: m
    data: Bytes  # row 0 is the top


class TaskState(Message, frozen=True, kw_only=True, tag=4):
    """`task/state`: a simulator's own success check at the start of period ``tick``."""

    version: V1 = 1
    session: U64
    tick: U64
    episode_tick: U64
    success: bool  # the simulator's own check
    metrics: tuple[tuple[str, float], ...]  # name with unit, value


class ModeRange(Record, frozen=True, kw_only=True):
    """SI command range of one mode of one part, one float64 per controlled value."""

    mode: U8
    lower: bytes  # per value, SI
    upper: bytes  # per value, SI


class HalPart(Record, frozen=True, kw_only=True):
    """One part as the HAL found it."""

    name: str  # as in robot.yaml
    simulator_part: str  # the simulator's name, empty on hardware
    joints: tuple[str, ...]  # in wire order
    ranges: tuple[ModeRange, ...]  # one per mode


class HalCamera(Record, frozen=True, kw_only=True):
    """One camera."""

    name: str  # as in its key
    width: U32  # pixels
    height: U32  # pixels
    period_ticks: U32  # from frame to frame


class HalStatus(Message, frozen=True, kw_only=True, tag=5):
    """`hal/status`: who the robot is and how it is paced."""

    version: V1 = 1
    session: U64
    robot: str
    robot_hash: Hash32
    pacing: Literal["realtime", "lockstep"]
    period_ns: U64  # ns, length of a tick
    tick: U64  # newest
    episode_tick: U64
    state: Literal["ready", "resetting", "holding", "fault"]
    detail: str  # in words
    joints: tuple[str, ...]  # commanded, in wire order
    passive_joints: tuple[str, ...]  # measured only
    parts: tuple[HalPart, ...]
    simulator_order: tuple[str, ...]  # the simulator's parts, as its action vector has them
    cameras: tuple[HalCamera, ...]
    has_task: bool  # task/state is published
    overruns: U64  # periods longer than a tick


class LayoutFault(Record, frozen=True, kw_only=True):
    """Why a layout vector could not be assembled (see `fairlead.errors.LayoutError`).

    kind: missing_frame, stale_frame, contested_frame, loop, missing_joint, missing_tick,
    not_finite, wrong_width, unknown_skill, no_assembler, failed (the layout's own code).
    """

    kind: str  # one of the words above
    name: str  # frame, joint or layout
    parent: str  # where the look-up started, or empty
    age_ticks: int  # of the newest usable transform, -1: none
    text: str  # in words


class LayoutState(Message, frozen=True, kw_only=True, tag=6):
    """`state/layout/<skill>`: the policy's state vector at ``tick``, or why there is none."""

    version: V1 = 1
    session: U64
    tick: U64
    episode_tick: U64
    oldest_tick: U64
    skill: str
    skill_hash: Hash32
    layout: str  # its name
    values: bytes | None  # the state vector
    fault: LayoutFault | None  # why there is none: exactly one of the two is set

    def __post_init__(self) -> None:
        if (self.values is None) == (self.fault is None):
            raise ValueError("exactly one of values and fault must be set")
