"""Run one goal from outside: send it, follow it, hand back how it ended."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from fairlead.errors import NoAnswerError, RefusedError, ServiceError
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_watch import GoalWatch, Progress
from fairlead.operate.runner_choice import choose_runner

REFRESH_S = 0.25
CANCEL_TIMEOUT_S = 3.0  # a runner gives its claim back within that


@dataclass(frozen=True)
class GoalWish:
    """What to ask a runner for. deadline_ticks 0: none; prompt "": the skill's own.

    runner: a service's name; "": the one that `choose_runner` finds for the skill.
    """

    skill: str
    prompt: str = ""
    deadline_ticks: int = 0
    stall_timeout_s: float = 30.0
    runner: str = ""


class GoalInterrupted(KeyboardInterrupt):
    """Ctrl-C while a goal ran; it has been cancelled, or else the robot stopped.

    Attributes:
        progress: where it stood; its result is None if the runner did not confirm in time.
        stopped: then, what was done about it, for people; else "".
    """

    def __init__(self, progress: Progress, stopped: str) -> None:
        super().__init__()
        self.progress = progress
        self.stopped = stopped


def run_goal(
    client: RobotClient,
    wish: GoalWish,
    on_progress: Callable[[Progress], None] = lambda progress: None,
) -> Progress:
    """Send one goal and follow it until it has a result.

    Raises:
        ConfigError: no runner, or none that is clear, for the skill.
        RefusedError: the runner did not take the goal.
        ServiceError: the runner went away meanwhile.
        GoalInterrupted: Ctrl-C; the goal has been cancelled. Where the runner does not
            confirm that, or a second Ctrl-C comes first, a protective stop is requested.
    """
    runner = choose_runner(client.deployment, wish.skill, wish.runner)
    watch = GoalWatch(client, runner)
    try:
        goal_id = client.goal(
            runner, wish.skill, wish.prompt, wish.deadline_ticks, wish.stall_timeout_s
        )
        try:
            return _follow(client, runner, watch, goal_id, on_progress)
        except KeyboardInterrupt:
            ended = _cancel(client, runner, watch, goal_id)
            stopped = "" if ended.result is not None else _stop(client, runner)
            raise GoalInterrupted(ended, stopped) from None
    finally:
        watch.close()


def _follow(
    client: RobotClient,
    runner: str,
    watch: GoalWatch,
    goal_id: int,
    on_progress: Callable[[Progress], None],
) -> Progress:
    while True:
        progress = watch.wait(goal_id, REFRESH_S)
        on_progress(progress)
        if progress.result is not None:
            return progress
        if runner not in client.alive:
            raise ServiceError(
                f"{runner} went away while the goal ran; see: fairlead logs {runner}"
            )


def _cancel(client: RobotClient, runner: str, watch: GoalWatch, goal_id: int) -> Progress:
    try:
        with suppress(RefusedError):  # it has just ended by itself
            client.cancel(runner, goal_id)
        return watch.wait(goal_id, CANCEL_TIMEOUT_S)
    except (NoAnswerError, KeyboardInterrupt):
        return watch.wait(goal_id, 0.0)


def _stop(client: RobotClient, runner: str) -> str:
    said = f"{runner} did not confirm that the goal ended"
    try:
        stop_id = client.stop(said)
    except NoAnswerError as error:
        return f"{said}, and no stop is confirmed: THE ROBOT MAY MOVE: {error}"
    return f"{said}: a protective stop holds the robot\n  try: fairlead reset {stop_id:016x}"
