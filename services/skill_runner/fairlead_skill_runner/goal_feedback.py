"""What a runner says of its goal."""

from __future__ import annotations

from fairlead.messages import GoalFeedback, GoalResult
from fairlead_skill_runner.goal_executor import Progress


def no_goal(source: str) -> GoalFeedback:
    """What a runner says of its goal before the first."""
    return as_feedback(source, 0, "", Progress("idle"), None)


def as_feedback(
    source: str, goal_id: int, skill: str, progress: Progress, result: GoalResult | None
) -> GoalFeedback:
    """How a goal stands."""
    return GoalFeedback(
        source=source,
        goal_id=goal_id,
        skill=skill,
        phase=progress.phase,
        tick=progress.tick,
        queue_depth=progress.queue_depth,
        inferences=progress.inferences,
        starved=progress.starved,
        last_refusal=progress.last_refusal,
        result=result,
    )
