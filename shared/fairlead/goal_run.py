"""Run one goal from outside: send it, follow it, hand back how it ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fairlead.client import RobotClient
from fairlead.errors import ServiceError
from fairlead.goal_watch import GoalWatch, Progress

REFRESH_S = 0.25


@dataclass(frozen=True)
class GoalWish:
    """What to ask a runner for. deadline_ticks 0: none; prompt "": the skill's own."""

    skill: str
    prompt: str = ""
    deadline_ticks: int = 0
    stall_timeout_s: float = 30.0


def run_goal(
    client: RobotClient,
    wish: GoalWish,
    on_progress: Callable[[Progress], None] = lambda progress: None,
) -> Progress:
    """Send one goal and follow it until it has a result; Ctrl-C cancels it.

    Raises:
        RefusedError: the runner did not take the goal.
        ServiceError: the runner went away meanwhile.
    """
    watch = GoalWatch(client)
    try:
        goal_id = client.goal(wish.skill, wish.prompt, wish.deadline_ticks, wish.stall_timeout_s)
        while True:
            try:
                progress = watch.wait(goal_id, REFRESH_S)
            except KeyboardInterrupt:
                client.cancel(goal_id)
                continue
            on_progress(progress)
            if progress.result is not None:
                return progress
            if client.runner not in client.alive:
                raise ServiceError(
                    f"the runner went away while the goal ran; see: fairlead logs {client.runner}"
                )
    finally:
        watch.close()
