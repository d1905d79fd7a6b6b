"""Episodes through the deployed services, in lockstep, read back from their traces."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ServiceError, expected
from fairlead.messages import ResetEpisodeReply
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead_tools.parity.episode_trace import EpisodeTrace
from fairlead_tools.parity.local_episode import require_each_period
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from fairlead_tools.writable import room

if TYPE_CHECKING:
    from fairlead.policy import Actions
    from fairlead_skill_runner import TraceRecord


_WRITTEN_TIMEOUT_S, _POLL_S = 10.0, 0.02


@dataclass(frozen=True)
class DeployedEpisode:
    """One episode from its reset to the goal's last tick; reset: how that went.

    calls: each policy call, by the tick it was for.
    """

    seed: int
    trace: EpisodeTrace
    reset: ResetEpisodeReply
    calls: list[TraceRecord]

    def raw_row(self, tick: int) -> Actions:
        """What the policy wrote for a tick, counted from the reset, shape ``[dim]``."""
        wanted = self.reset.tick - self.reset.held_ticks + tick
        call = next(call for call in reversed(self.calls) if call.tick <= wanted)
        return np.array(call.proposed[wanted - call.tick], dtype="<f4")


def deployed_episodes(
    source: Path,
    wish: GoalOptions,
    seeds: Iterable[int],
    folder: Path,
    on_progress: Callable[[Progress], None],
) -> list[DeployedEpisode]:
    """Run a goal, for each seed in an episode of its own, on a private copy of ``source``.

    Args:
        folder: emptied, then holds the services' state and traces.

    Raises:
        ConfigError: a row of the skill is for more than a step of the simulator.
        ServiceError: a service failed, or the goal did for another reason than the task.
    """
    deployment, skill = load_deployment(source), load_skill(wish.skill)
    require_each_period("parity", skill, load_robot(deployment.robot))
    hal, runner = deployment.only("hal_sim"), deployment.only("skill_runner")
    options: dict[str, dict[str, Any]] = {
        hal: {"trace": True, **({} if skill.images else {"cameras": []})},
        runner: {"trace": True},
    }
    scratch = make_scratch(source, folder, ScratchOptions(pacing="lockstep", options=options))
    ended = []
    with scratch_robot(scratch) as robot:
        for seed in seeds:
            reset = robot.client.reset_episode(seed)
            robot.client.arm()
            progress = run_goal(robot.client, wish, on_progress)
            robot.client.disarm()
            result = progress.result
            assert result is not None
            if result.outcome not in ("succeeded", "deadline"):
                raise ServiceError(
                    f"parity: the deployed goal {result.outcome}: {result.kind}: {result.detail}; "
                    f"logs: {folder / 'logs'}"
                )
            # The next goal's calls take the place of this one's.
            calls = written_calls(folder / runner, calls_with_rows(progress))
            ended.append((seed, reset, result, calls))
    found = []
    for seed, reset, result, calls in ended:
        # The goal ends on what it sees in its last tick, before a row acts in it.
        ticks = range(reset.tick - reset.held_ticks, result.last_tick)
        trace = read_episode(folder / hal, calls, ticks, result.outcome == "succeeded")
        found.append(DeployedEpisode(seed, trace, reset, calls))
    return found


def calls_with_rows(progress: Progress) -> int:
    """Calls of the policy that are in the trace: the last one may have ended the goal instead."""
    result = progress.result
    ended = result is not None and (result.decided_by == "policy" or result.kind == "policy_error")
    return progress.inferences - ended


def written_calls(runner: Path, count: int) -> list[TraceRecord]:
    """A goal's policy calls, once the runner has written them all.

    Raises:
        ServiceError: it did not.
    """
    until, trace = time.monotonic() + _WRITTEN_TIMEOUT_S, runner / "trace.jsonl"
    while (found := trace.read_bytes().count(b"\n")) < count:
        if time.monotonic() > until:
            got = f"{found} ({room(trace)})"
            raise ServiceError(expected(str(trace), f"{count} policy calls", got))
        time.sleep(_POLL_S)
    return _calls(runner)


def read_episode(
    hal: Path, calls: Sequence[TraceRecord], ticks: range, succeeded: bool
) -> EpisodeTrace:
    """One episode from its policy calls and the traces in the state folder of its HAL.

    Args:
        ticks: from the reset to the last one in which a row acted.

    Raises:
        ServiceError: the HAL's trace misses a tick.
    """
    episode = EpisodeTrace(succeeded=succeeded)
    for call in calls:
        episode.observations.append(np.asarray(call.state, dtype="<f8").tobytes())
        episode.pictures.append(json.dumps(dict(call.pictures), sort_keys=True).encode())
        episode.actions.append(np.asarray(call.proposed, dtype="<f4").tobytes())
    steps, motion = by_tick(hal / "trace.jsonl"), by_tick(hal / "motion.jsonl")
    for tick in ticks:
        if tick not in steps or tick not in motion:
            raise ServiceError(f"parity: the HAL's trace has no tick {tick}; see {hal}")
        for name in ("packed", "qpos", "qvel"):
            getattr(episode, name).append(bytes.fromhex(steps[tick][name]))
        episode.held.append(any(hold for hold, _, _ in motion[tick]["acted"]))
    return episode


def _calls(runner: Path) -> list[TraceRecord]:
    from fairlead_skill_runner import read_trace

    return list(read_trace(runner / "trace.jsonl"))


def by_tick(file: Path) -> dict[int, dict[str, Any]]:
    """A HAL's ``trace.jsonl`` or ``motion.jsonl``, the last whole line of each tick."""
    *lines, _ = file.read_text(encoding="ascii").split("\n")
    return {line["tick"]: line for line in map(json.loads, lines)}
