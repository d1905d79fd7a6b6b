"""A policy is loaded before the robot is armed: a gate that waits too long disarms again."""

from __future__ import annotations

from fairlead.messages import BEING_LOADED, GateState
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions
from fairlead_tools.cli.console import ProgressLine


def load_first(client: RobotClient, wish: GoalOptions, line: ProgressLine) -> None:
    """Return once the runner has loaded a goal's policy; at once where the gate is stopped.

    Args:
        line: where it is shown, with the seconds it takes, if it takes any.

    Raises:
        RefusedError: the runner does not offer the skill, or could not load its policy.
        NoAnswerError: the runner does not answer.
    """
    if client.gate_status().state >= GateState.STOPPED:
        return  # arming is refused, with the reason
    with line.counting() as say:
        while client.load(wish.skill, wish.runner).text.endswith(BEING_LOADED):
            say(f"{wish.skill}: its policy is being loaded")
