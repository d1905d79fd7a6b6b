"""Every message on the wire: msgpack arrays, fields by position.

Element 0 is the message's type id, element 1 its version, then the fields in the order
written here. Blocks of numbers are ``bin``: little-endian float64, row-major (see
`floats` and `pack_floats`). Ids are uint64, hashes 32 bytes, 0 means "none". A message
of another type or version is refused, never guessed; a new field is a new version.

Ticks count control periods of the HAL from 1; clocks are never compared.

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
from fairlead.messages.codec import MESSAGE_TYPES, RECORD_TYPES, decode, encode, encoding_of
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
from fairlead.messages.goal import Cancel, Goal, GoalAccepted, GoalFeedback, GoalResult
from fairlead.messages.message import (
    NO_HASH,
    NO_TRACE,
    U8,
    U32,
    U64,
    V1,
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
    "decode",
    "encode",
    "encoding_of",
    "floats",
    "pack_floats",
]
