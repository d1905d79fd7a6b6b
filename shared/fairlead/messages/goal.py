"""Running a skill: the goal, its progress, its end."""

from __future__ import annotations

from typing import Literal

from fairlead.messages.message import U32, U64, V1, Hash32, Message, Record


class Goal(Message, frozen=True, kw_only=True, tag=32):
    """Ask a runner to run a skill. Reply: `GoalAccepted`, at once."""

    version: V1 = 1
    skill: str
    skill_hash: Hash32  # NO_HASH: whatever version the runner has
    prompt: str  # "": the skill's own
    deadline_ticks: U64  # 0: none
    stall_timeout_s: float


class GoalAccepted(Message, frozen=True, kw_only=True, tag=33):
    """The goal has begun; its id stands in the runner's feedback and cancels it."""

    version: V1 = 1
    goal_id: U64


class Cancel(Message, frozen=True, kw_only=True, tag=34):
    """End a goal as soon as possible. Reply: `Done`."""

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
