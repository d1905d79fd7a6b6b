"""Run one goal from outside, blocking: send it, follow it, hand back how it ended."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from fairlead.operate.client import RobotClient
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.robot import STALL_TIMEOUT_S


@dataclasses.dataclass(frozen=True)
class GoalOptions:
    """What to ask a runner for; each field as in `Robot.run`."""

    skill: str
    prompt: str = ""
    deadline_ticks: int = 0
    stall_timeout_s: float = STALL_TIMEOUT_S
    runner: str = ""
    hand_over_to: str = ""


def run_goal(
    client: RobotClient,
    wish: GoalOptions,
    on_progress: Callable[[Progress], None] = lambda progress: None,
) -> Progress:
    """Send one goal and follow it until it has a result; raises as `Robot.run` and its goal.

    Ended early, by Ctrl-C or an error, the goal is cancelled; if the robot had to be stopped for
    that, the log says so.
    """
    goal = client.run(**dataclasses.asdict(wish))
    try:
        with goal:
            for progress in goal:
                on_progress(progress)
    finally:
        goal.log_stopped()
    return goal.progress
