"""One episode through the deployed services, in lockstep, read back from their traces."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fairlead.errors import ServiceError
from fairlead.messages import ResetEpisodeReply
from fairlead.operate.goal_run import GoalWish, run_goal
from fairlead.operate.goal_watch import Progress
from fairlead.operate.scratch_robot import scratch_robot
from fairlead.parity.episode_trace import EpisodeTrace
from fairlead.supervisor.scratch import ScratchOptions, make_scratch


def deployed_episode(
    source: Path,
    wish: GoalWish,
    seed: int,
    folder: Path,
    on_progress: Callable[[Progress], None],
) -> tuple[EpisodeTrace, ResetEpisodeReply]:
    """Run a goal on a private copy of deployment ``source``.

    Args:
        folder: emptied, then holds the services' state and traces.

    Returns:
        What was computed from the reset to the goal's last tick, and how the reset went.

    Raises:
        ServiceError: a service failed, or the goal did for another reason than the task.
    """
    options: dict[str, dict[str, Any]] = {
        "hal": {"trace": True, "cameras": []},
        "runner": {"trace": True},
    }
    scratch = make_scratch(source, folder, ScratchOptions(pacing="lockstep", options=options))
    with scratch_robot(scratch) as robot:
        reset = robot.client.reset_episode(seed)
        robot.client.arm()
        result = run_goal(robot.client, wish, on_progress).result
        robot.client.disarm()
    assert result is not None
    if result.outcome not in ("succeeded", "deadline"):
        raise ServiceError(
            f"parity: the deployed goal {result.outcome}: {result.kind}: {result.detail}; "
            f"logs: {folder / 'logs'}"
        )
    # The goal ends on what it sees in its last tick, before a row acts in it.
    ticks = range(reset.tick - reset.held_ticks, result.last_tick)
    succeeded = result.outcome == "succeeded"
    return read_episode(folder / "hal", folder / "runner", ticks, succeeded), reset


def read_episode(hal: Path, runner: Path, ticks: range, succeeded: bool) -> EpisodeTrace:
    """One episode from the traces in the state folders of a HAL and a runner.

    Args:
        ticks: from the reset to the last one in which a row acted.

    Raises:
        ServiceError: the HAL's trace misses a tick.
    """
    from fairlead_skill_runner.trace import read_trace

    episode = EpisodeTrace(succeeded=succeeded)
    for call in read_trace(runner / "trace.jsonl"):
        episode.observations.append(np.asarray(call.state, dtype="<f8").tobytes())
        episode.actions.append(np.asarray(call.actions, dtype="<f4").tobytes())
    lines = (hal / "trace.jsonl").read_text(encoding="ascii").splitlines()
    steps = {step["tick"]: step for step in map(json.loads, lines)}
    for tick in ticks:
        if tick not in steps:
            raise ServiceError(f"parity: the HAL's trace has no tick {tick}; see {hal}")
        for name in ("packed", "qpos", "qvel"):
            getattr(episode, name).append(bytes.fromhex(steps[tick][name]))
    return episode
