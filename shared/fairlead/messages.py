"""Every message on the wire: msgpack arrays, fields by position.

Element 0 is the message's type id, element 1 its version, then the fields in the order
written here. Blocks of numbers are ``bin``: little-endian float64, row-major (see
`floats` and `pack_floats`). Ids are uint64, hashes 32 bytes, 0 means "none". A message
of another type or version is refused, never guessed; a new field is a new version.

Ticks count control periods of the HAL from 1; clocks are never compared.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Annotated, Literal, TypeVar, cast

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.errors import MessageError

FloatArray = npt.NDArray[np.float64]

U64 = Annotated[int, msgspec.Meta(ge=0)]  # msgpack itself bounds it by 2**64 - 1
U32 = Annotated[int, msgspec.Meta(ge=0, le=2**32 - 1)]
U8 = Annotated[int, msgspec.Meta(ge=0, le=255)]
Hash32 = Annotated[bytes, msgspec.Meta(min_length=32, max_length=32)]
V1 = Literal[1]

NO_HASH = bytes(32)
NO_TRACE = bytes(24)


def pack_floats(values: npt.ArrayLike) -> bytes:
    """Encode numbers as the wire's little-endian float64 block, row-major."""
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def floats(block: bytes, width: int | None = None) -> FloatArray:
    """Decode a float64 block: shape ``[n]``, or ``[rows, width]`` where width is given.

    Raises:
        MessageError: if the block is not a whole number of float64 (or of rows).
    """
    row = 8 * (width or 1)
    if row <= 0 or len(block) % row:
        raise MessageError(f"float block: expected a multiple of {row} bytes, got {len(block)}")
    array = np.frombuffer(block, dtype="<f8")
    return array if width is None else array.reshape(-1, width)


class Message(
    msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True, kw_only=True
):
    """Base of every message; subclasses add a type id (their tag) and a version."""


class Record(
    msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True, kw_only=True
):
    """Base of the records inside messages: no type id, no version of their own."""


# --- robot -> everyone -------------------------------------------------------------


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


# --- assembler -> runner -----------------------------------------------------------


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


# --- runner -> gate -> hal ---------------------------------------------------------


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
    names, "" if none. value, limit, margin (limit minus value, in the axis' unit):
    0.0 if code is 0. released_first/last: ticks, 0 if nothing was released.
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


class StopLevel(Message, frozen=True, kw_only=True, tag=12):
    """A protective stop request, repeated every 50 ms until a lease lists ``stop_id``.

    stop_id: random, never 0. A HAL that reads 0, or bytes that are no StopLevel, raises a
    stop under an id of its own: a stop that is badly said still stops.
    """

    version: V1 = 1
    stop_id: U64
    by: str
    reason: str


class Heartbeat(Message, frozen=True, kw_only=True, tag=13):
    """The runner is alive and still wants its claim."""

    version: V1 = 1
    claim_id: U64


# --- queries and their replies -----------------------------------------------------


class Refusal(Message, frozen=True, kw_only=True, tag=20):
    """The error reply to any query."""

    version: V1 = 1
    who: str
    reason: str
    fix: str


class Done(Message, frozen=True, kw_only=True, tag=21):
    """The plain success reply."""

    version: V1 = 1
    text: str


class StatusQuery(Message, frozen=True, kw_only=True, tag=22):
    """Ask for `GateStatus` or `HalStatus` on their keys."""

    version: V1 = 1


class Arm(Message, frozen=True, kw_only=True, tag=23):
    """Reply: `ArmReply`."""

    version: V1 = 1
    by: str


class ArmReply(Message, frozen=True, kw_only=True, tag=24):
    version: V1 = 1
    epoch: U64
    session: U64


class Disarm(Message, frozen=True, kw_only=True, tag=25):
    """Reply: `Done`."""

    version: V1 = 1
    by: str


class Reset(Message, frozen=True, kw_only=True, tag=26):
    """Acknowledge one stop or latch by its id. Reply: `Done`."""

    version: V1 = 1
    by: str
    id: U64


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
    version: V1 = 1
    claim_id: U64
    epoch: U64
    session: U64


class Release(Message, frozen=True, kw_only=True, tag=29):
    """Give a claim back. Reply: `Done`."""

    version: V1 = 1
    source: str
    claim_id: U64


class ResetEpisode(Message, frozen=True, kw_only=True, tag=30):
    """Start a new simulated episode. Reply: `ResetEpisodeReply`, when standing still."""

    version: V1 = 1
    seed: U64


class ResetEpisodeReply(Message, frozen=True, kw_only=True, tag=31):
    version: V1 = 1
    tick: U64
    episode_tick: U64
    held_ticks: U64


class Goal(Message, frozen=True, kw_only=True, tag=32):
    """Ask a runner to run a skill. Reply: `GoalAccepted`, at once."""

    version: V1 = 1
    skill: str
    skill_hash: Hash32  # NO_HASH: whatever version the runner has
    prompt: str  # "": the skill's own
    deadline_ticks: U64  # 0: none
    stall_timeout_s: float


class GoalAccepted(Message, frozen=True, kw_only=True, tag=33):
    version: V1 = 1
    goal_id: U64


class Cancel(Message, frozen=True, kw_only=True, tag=34):
    """Reply: `Done`."""

    version: V1 = 1
    goal_id: U64
    by: str


class GoalResult(Record, frozen=True, kw_only=True):
    """How a goal ended.

    kind: "" on success, else the typed reason, for example ``layout_missing_frame``,
    ``policy_error``, ``claim_lost``, ``claim_refused``, ``stalled``, ``new_session``.
    """

    outcome: Literal["succeeded", "failed", "cancelled", "deadline"]
    decided_by: Literal["task", "policy", "operator", "runner"]
    kind: str
    detail: str
    first_tick: U64
    last_tick: U64


class GoalFeedback(Message, frozen=True, kw_only=True, tag=35):
    """Progress of the newest goal, on change and at 2 Hz; ``result`` is set at the end."""

    version: V1 = 1
    source: str
    goal_id: U64
    skill: str
    phase: str
    tick: U64
    queue_depth: U32
    inferences: U64
    starved: U64
    last_refusal: str
    result: GoalResult | None


_ENCODER = msgspec.msgpack.Encoder()

MESSAGE_TYPES: tuple[type[Message], ...] = tuple(Message.__subclasses__())
"""Every message type, in the order of this file."""

_DECODERS: dict[type[Message], msgspec.msgpack.Decoder[Message]] = {
    kind: msgspec.msgpack.Decoder(kind) for kind in MESSAGE_TYPES
}

_HEAD = msgspec.msgpack.Decoder(list[msgspec.Raw])
_UINT = msgspec.msgpack.Decoder(U64)
_NAMES = {kind.__struct_config__.tag: kind.__name__ for kind in MESSAGE_TYPES}

M = TypeVar("M", bound=Message)


def encode(message: Message) -> bytes:
    """Encode one message for the wire."""
    return _ENCODER.encode(message)


def decode(kind: type[M], data: bytes) -> M:
    """Decode one message of exactly this type and version.

    Raises:
        MessageError: naming the type and version that came instead, or the path of the
            field that does not fit.
    """
    try:
        return cast(M, _DECODERS[kind].decode(data))
    except (ValueError, RecursionError) as error:  # msgspec's own errors are ValueErrors
        wanted, got = f"{kind.__name__} v1", _announced(data)
        if got not in ("", wanted):
            raise MessageError(f"expected {wanted}, got {got} ({len(data)} bytes)") from None
        raise MessageError(f"{kind.__name__}: {error} ({len(data)} bytes)") from None


def _announced(data: bytes) -> str:
    """The type and version that the first two elements name, "" where they cannot be read."""
    try:
        type_id, version = _HEAD.decode(data)[:2]
        numbers = (_UINT.decode(type_id), _UINT.decode(version))
    except (ValueError, RecursionError):
        return ""
    return f"{_NAMES.get(numbers[0], f'unknown type {numbers[0]}')} v{numbers[1]}"


def encoding_of(kind: type[Message]) -> str:
    """The Zenoh encoding announced for a type: tools read it, services read the bytes."""
    return f"application/msgpack;fairlead.{kind.__name__}.v1"
