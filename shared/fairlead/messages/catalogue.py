"""Every message and every record there is, in the order of docs/wire-format.md."""

from __future__ import annotations

from fairlead.messages.action import ActionChunk, ActionPart, SafeChunk
from fairlead.messages.claim import Claim, ClaimReply, Heartbeat, LimitOverride, Release
from fairlead.messages.gate_status import ClaimInfo, GateStatus
from fairlead.messages.goal import Cancel, Goal, GoalAccepted, GoalFeedback, GoalResult
from fairlead.messages.hal_status import HalCamera, HalPart, HalStatus, ModeRange
from fairlead.messages.layout_state import LayoutFault, LayoutState
from fairlead.messages.lease import Grant, Lease
from fairlead.messages.message import Message, Record
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
from fairlead.messages.robot_state import (
    Acted,
    Image,
    JointState,
    TaskState,
    Transform,
    TransformBatch,
)
from fairlead.messages.verdict import Verdict

MESSAGE_TYPES: tuple[type[Message], ...] = (
    JointState,
    TransformBatch,
    Image,
    TaskState,
    HalStatus,
    LayoutState,
    ActionChunk,
    SafeChunk,
    Lease,
    Verdict,
    GateStatus,
    StopLevel,
    Heartbeat,
    Refusal,
    Done,
    StatusQuery,
    Arm,
    ArmReply,
    Disarm,
    Reset,
    Claim,
    ClaimReply,
    Release,
    ResetEpisode,
    ResetEpisodeReply,
    Goal,
    GoalAccepted,
    Cancel,
    GoalFeedback,
)
"""Every message type, by type id."""

RECORD_TYPES: tuple[type[Record], ...] = (
    Acted,
    Transform,
    ModeRange,
    HalPart,
    HalCamera,
    LayoutFault,
    ActionPart,
    Grant,
    ClaimInfo,
    LimitOverride,
    GoalResult,
)
"""Every record that stands inside messages."""
