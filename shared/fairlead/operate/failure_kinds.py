"""How goals fail, for programs: `GoalResult.kind` of what did not succeed."""

from __future__ import annotations

from typing import Literal, get_args

from fairlead.errors import LayoutFailure

OfRunner = Literal[
    "already_solved", "camera_lost", "cancelled", "claim_lost", "claim_refused", "deadline",
    "error", "hal_fault", "internal_error", "layout_mismatch", "layout_missing", "new_session",
    "no_answer", "not_admitted", "policy_error", "stalled",
]  # fmt: skip
"""What a runner says."""

OF_GO_TO = ("bad_goal", "goal_outside_zones")
"""What the backend go_to says; other policies have kinds of their own."""

FAILURE_KINDS: tuple[str, ...] = (
    *get_args(OfRunner), *(f"layout_{one}" for one in get_args(LayoutFailure)), *OF_GO_TO
)  # fmt: skip
