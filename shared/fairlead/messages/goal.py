"""Running a skill: the goal, its progress, its end."""

from __future__ import annotations

from typing import Literal

from fairlead.messages.message import U32, U64, V1, Hash32, Message, Record


class Goal(Message, frozen=True, kw_only=True, tag=32):
    """Query `skill/<source>/goal`: run a skill. Reply: `GoalAccepted`, at once."""

    version: V1 = 1
    skill: str
    skill_hash: Hash32  # zeros: whatever version the runner has
    prompt: str  # empty: the skill's own
    deadline_ticks: U64  # 0: none
    stall_timeout_s: float  # s without released rows, the policy's time not counted
    hand_over_to: str = ""  # runner to whose next goal its claim is offered; may be absent
    by: str = ""  # who asks; may be absent


class GoalAccepted(Message, frozen=True, kw_only=True, tag=33):
    """The goal has begun; its id stands in the runner's feedback and cancels it."""

    version: V1 = 1
    goal_id: U64


class Cancel(Message, frozen=True, kw_only=True, tag=34):
    """Query `skill/<source>/cancel`: end a goal as soon as possible. Reply: `Done`."""

    version: V1 = 1
    goal_id: U64
    by: str


BEING_LOADED = "is being loaded"


class Load(Message, frozen=True, kw_only=True, tag=36):
    """Query `skill/<source>/load`: load a policy before its goal.

    Reply: `Done`, once it is loaded; after 1 s at the latest, with a text that ends with
    `BEING_LOADED`: ask again to wait on. `Refusal` if it cannot be loaded.
    """

    version: V1 = 1
    skill: str
    by: str


class GoalResult(Record, frozen=True, kw_only=True):
    """How a goal ended."""

    outcome: Literal["succeeded", "failed", "cancelled", "deadline"]
    decided_by: Literal["task", "policy", "operator", "runner"]
    kind: str  # reason, such as claim_lost; empty on success
    detail: str  # in words
    first_tick: U64  # worked on
    last_tick: U64  # worked on


class GoalFeedback(Message, frozen=True, kw_only=True, tag=35):
    """`skill/<source>/feedback`: progress of the newest goal."""

    version: V1 = 1
    source: str
    goal_id: U64
    skill: str
    phase: str  # in the policy's words
    tick: U64  # newest worked on
    queue_depth: U32  # released rows not yet executed
    inferences: U64  # calls of the policy
    starved: U64  # ticks without a row
    last_refusal: str  # in words
    result: GoalResult | None  # nil until the end

    @property
    def is_running(self) -> bool:
        """Whether there has been a goal, and it has not ended."""
        return self.goal_id != 0 and self.result is None
