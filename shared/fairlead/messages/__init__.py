"""Every message on the wire: msgpack arrays, fields by position.

A message is its type id (``tag``), its version (1), then its fields in the order written in its
class; a record inside a message has neither id nor version. docs/wire-format.md has the encoding.
``U8``, ``U32``, ``U64``: unsigned integers. ``Hash32``: ``bin`` of 32 bytes. ``bytes``: ``bin``,
little-endian float64, row-major, unless its words say otherwise (`floats`, `pack_floats`).
``tuple[X, ...]``: an array of any length. Ids are random; 0, or a hash of zeros, means none.

These fields mean the same everywhere and have no words in the classes:

    session       U64     the HAL's run: drawn when the HAL starts
    epoch         U64     the gate's arming: drawn at start and at every arm
    claim_id      U64     the claim: drawn by the gate
    goal_id       U64     the goal
    tick          U64     control period it is about, from 1
    episode_tick  U64     first tick of this episode; older transforms and pictures do not count
    oldest_tick   U64     oldest input that is not static
    source        str     who sends chunks: the runner's name, as in its keys
    skill         str     id of the skill
    robot         str     id of the robot
    by            str     who asks, for the log
    mode          U8      control mode
    robot_hash    Hash32  SHA-256 of robot.yaml without its safety block, and of the URDF
    skill_hash    Hash32  SHA-256 of the skill's manifest
    config_hash   Hash32  SHA-256 of the gate's configuration file

One file a topic; this is the face that everything else imports from:

    state      robot -> everyone; the state vector, assembler -> runner
    action     runner -> gate -> HAL
    gate       gate -> everyone; claims, runner -> gate
    operation  queries to the gate and the HAL, and what they answer
    goal       operator -> runner
    message    what fields are made of
    codec      every type by its id; to bytes and back
"""

from __future__ import annotations

from fairlead.messages.action import ActionChunk, ActionPart, SafeChunk
from fairlead.messages.codec import (
    MESSAGE_TYPES,
    RECORD_TYPES,
    check_fields,
    decode,
    encode,
    encode_parts,
    encoding_of,
)
from fairlead.messages.gate import (
    Claim,
    ClaimInfo,
    ClaimReply,
    Decision,
    GateState,
    GateStatus,
    Grant,
    Heartbeat,
    Lease,
    LimitOverride,
    Outcome,
    Release,
    Verdict,
)
from fairlead.messages.goal import (
    BEING_LOADED,
    Cancel,
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    Load,
)
from fairlead.messages.message import (
    NO_HASH,
    NO_TRACE,
    U8,
    U32,
    U64,
    V1,
    Bytes,
    FloatArray,
    Hash32,
    Message,
    Record,
    floats,
    pack_floats,
)
from fairlead.messages.operation import (
    Arm,
    ArmReply,
    Disarm,
    Done,
    Refusal,
    Reset,
    ResetEpisode,
    ResetEpisodeReply,
    StatusQuery,
    StopLevel,
)
from fairlead.messages.state import (
    HELD,
    Acted,
    HalCamera,
    HalPart,
    HalStatus,
    Hold,
    Image,
    JointState,
    LayoutFault,
    LayoutState,
    ModeRange,
    TaskState,
    Transform,
    TransformBatch,
)

__all__ = [
    "BEING_LOADED",
    "HELD",
    "MESSAGE_TYPES",
    "NO_HASH",
    "NO_TRACE",
    "RECORD_TYPES",
    "U8",
    "U32",
    "U64",
    "V1",
    "Acted",
    "ActionChunk",
    "ActionPart",
    "Arm",
    "ArmReply",
    "Bytes",
    "Cancel",
    "Claim",
    "ClaimInfo",
    "ClaimReply",
    "Decision",
    "Disarm",
    "Done",
    "FloatArray",
    "GateState",
    "GateStatus",
    "Goal",
    "GoalAccepted",
    "GoalFeedback",
    "GoalResult",
    "Grant",
    "HalCamera",
    "HalPart",
    "HalStatus",
    "Hash32",
    "Heartbeat",
    "Hold",
    "Image",
    "JointState",
    "LayoutFault",
    "LayoutState",
    "Lease",
    "LimitOverride",
    "Load",
    "Message",
    "ModeRange",
    "Outcome",
    "Record",
    "Refusal",
    "Release",
    "Reset",
    "ResetEpisode",
    "ResetEpisodeReply",
    "SafeChunk",
    "StatusQuery",
    "StopLevel",
    "TaskState",
    "Transform",
    "TransformBatch",
    "Verdict",
    "check_fields",
    "decode",
    "encode",
    "encode_parts",
    "encoding_of",
    "floats",
    "pack_floats",
]
