"""What the processes cost: a lockstep episode through them, beside the same steps in one.

Both run alternately, without cameras, so that what the machine does to one it does to the
other. Counted from the first tick with a released row to the end of the episode: start-up
and reset are left out on both sides.

    .venv/bin/python -m bench.loop [--seed 0] [--rounds 3] [--json]

Prints milliseconds per tick of each and their ratio, the median over the rounds.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
from dataclasses import dataclass
from pathlib import Path

from fairlead.deploy.deployment import load_deployment
from fairlead.messages import Hold, ResetEpisodeReply
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead.skill.manifest import load_skill
from fairlead_tools.parity.local_episode import local_episode
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

SKILL = "oracle-counter-to-cabinet"
SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
DEADLINE_TICKS = 800


@dataclass(frozen=True)
class Round:
    """One episode each way: wall time per tick [ms]."""

    ticks: int
    deployed_ms: float
    local_ms: float

    @property
    def ratio(self) -> float:
        """How often the in-process loop fits into a tick through the processes."""
        return self.deployed_ms / self.local_ms


def run_round(seed: int, folder: Path) -> Round:
    """One episode through the processes, then its steps in this process."""
    scratch = make_scratch(SOURCE, folder, ScratchOptions(pacing="lockstep"))
    with scratch_robot(scratch) as robot:
        reset = robot.client.reset_episode(seed)
        robot.client.arm()
        result = run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=DEADLINE_TICKS)).result
        robot.client.disarm()
    assert result is not None, "the goal ended without a result"
    ticks, seconds = moving_time(folder / "hal" / "motion.jsonl", result.last_tick)
    local_ticks, local_seconds = local_time(seed, reset, ticks)
    return Round(ticks, 1e3 * seconds / ticks, 1e3 * local_seconds / local_ticks)


def moving_time(log: Path, last_tick: int) -> tuple[int, float]:
    """Ticks and seconds from the first executed row to ``last_tick``, by the HAL's own log."""
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    moving = [
        line
        for line in lines
        if line["tick"] <= last_tick and any(hold == Hold.NONE for hold, _, _ in line["acted"])
    ]
    first, last = moving[0], moving[-1]
    return last["tick"] - first["tick"], (last["stamp_ns"] - first["stamp_ns"]) / 1e9


def local_time(seed: int, reset: ResetEpisodeReply, ticks: int) -> tuple[int, float]:
    """Ticks and seconds of the same steps in this process."""
    most_ticks = reset.held_ticks + ticks
    episode = local_episode(load_deployment(SOURCE), load_skill(SKILL), seed, reset, most_ticks)
    return len(episode.packed) - reset.held_ticks, episode.seconds


def main() -> None:
    """Run the rounds and print them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=0, help="of the episode")
    parser.add_argument("--rounds", type=int, default=3, help="episodes each way")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rounds = [
            run_round(arguments.seed, Path(folder) / str(index))
            for index in range(arguments.rounds)
        ]
    ratio = statistics.median(one.ratio for one in rounds)
    if arguments.json:
        rows = [vars(one) | {"ratio": one.ratio} for one in rounds]
        print(json.dumps({"rounds": rows, "ratio": ratio}))
        return
    for one in rounds:
        print(
            f"{one.ticks} ticks: processes {one.deployed_ms:.2f} ms a tick, "
            f"one process {one.local_ms:.2f} ms, ratio {one.ratio:.2f}"
        )
    print(f"bench/loop: median ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
