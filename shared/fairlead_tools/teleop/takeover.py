"""A person and a policy take turns: the goal ends, the claim is the person's, and back again."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numpy as np

from fairlead.errors import RefusedError, ServiceError
from fairlead.messages import GoalResult
from fairlead.operate.blocking import BlockingClaim
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions
from fairlead_tools.teleop.device import InputDevice

SOURCE = "teleop"
LOOK_S = 0.02
"""How often the device is read while a policy drives."""
FREED_S = 3.0
"""A runner gives its parts back well within that of its goal's end."""


def watch_policy(
    client: RobotClient, wish: GoalOptions, device: InputDevice, show: Callable[[Progress], None]
) -> GoalResult | tuple[str, ...]:
    """Run a goal until it ends, or until the person lets the clutch in: then it is cancelled.

    Args:
        wish: the goal, with its runner.

    Returns:
        How it ended by itself, or by the person's wish to quit; else the parts it had.

    Raises:
        RefusedError: the runner does not take the goal.
        ServiceError: the runner or the device went away.
        NoAnswerError: the runner does not confirm the end; the robot is stopped then.
    """
    goal = client.run(**dataclasses.asdict(wish))
    was_out = False  # a clutch held since the last turn takes nothing over
    try:
        with goal:
            while (result := goal.progress.result) is None:
                asked = device.read(time.monotonic(), np.zeros(0))
                if asked.wish == "quit":
                    return goal.cancel()
                if asked.clutch and was_out:
                    parts = _parts_of(client, wish.runner)
                    goal.cancel()
                    return parts
                was_out = was_out or not asked.clutch
                if wish.runner not in client.alive:
                    raise ServiceError(f"{wish.runner} went away while the goal ran")
                show(goal.progress)
                time.sleep(LOOK_S)
            return result
    finally:
        goal.log_stopped()


def _parts_of(client: RobotClient, source: str) -> tuple[str, ...]:
    claims = client.gate_status().claims
    return tuple(part for claim in claims if claim.source == source for part in claim.parts)


@contextmanager
def taken(
    client: RobotClient, parts: Sequence[str], task: str, source: str = SOURCE
) -> Iterator[BlockingClaim]:
    """Hold parts while the block lasts; who lets go of them a moment later is waited for.

    Raises:
        RefusedError: somebody still has one.
    """
    until_s = time.monotonic() + FREED_S
    with ExitStack() as held:
        while True:
            try:
                claim = client.claim(parts, source=source, task=task)
                held.enter_context(claim)
                break
            except RefusedError:
                if time.monotonic() > until_s:
                    raise
            time.sleep(LOOK_S)
        yield claim
