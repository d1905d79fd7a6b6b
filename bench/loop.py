"""What the processes cost: a lockstep episode through them, beside the same steps in one.

Both run alternately, without cameras, so that what the machine does to one it does to the
other. Counted from the first tick with a released row to the end of the episode: start-up
and reset are left out on both sides.

    .venv/bin/python -m bench.loop [--seed 0] [--rounds 3] [--json] [--write]

Prints milliseconds per tick of each and their ratio, the median over the rounds; then, of one
more episode with a listener on the robot's bus, where a tick goes and what each process took.
--write puts the tables into docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.page import write_table
from bench.tick_watch import Spent, TickWatch, spent
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


@dataclass(frozen=True)
class Watched:
    """One more episode: where its ticks go [ms], and what each service took a tick."""

    segments: dict[str, dict[str, float]]
    services: dict[str, Spent]


def run_watched(seed: int, folder: Path) -> Watched:
    """An episode through the processes with a listener, which is left out of the ratio."""
    scratch = make_scratch(SOURCE, folder, ScratchOptions(pacing="lockstep"))
    with scratch_robot(scratch) as robot:
        robot.client.reset_episode(seed)
        robot.client.arm()
        (runner,) = scratch.deployment.runners
        watch = TickWatch(robot.client.bus, robot.client.keys, SKILL, runner)
        pids = {name: robot.supervisor.pid(name) for name in scratch.deployment.services}
        before = {name: spent(pid) for name, pid in pids.items()}
        result = run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=DEADLINE_TICKS)).result
        after = {name: spent(pid) for name, pid in pids.items()}
    assert result is not None, "the goal ended without a result"
    ticks = result.last_tick - result.first_tick
    return Watched(
        watch.segments(),
        {name: took.since(before[name]).a_tick(ticks) for name, took in after.items()},
    )


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


def ticks_table(watched: Watched) -> str:
    """Markdown: where a tick goes."""
    columns = ("assembler", "runner", "gate", "HAL", "tick")
    lines = [
        "| a tick that | of these | state to vector ms | vector to chunk ms | to lease ms "
        "| lease to next state ms | whole ms |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, found in watched.segments.items():
        cells = [f"{found[column]:.2f}" if column in found else "" for column in columns]
        lines.append(f"| {name} | {found['ticks']:.0f} | {' | '.join(cells)} |")
    return "\n".join(lines)


def services_table(watched: Watched) -> str:
    """Markdown: what each service took a tick, and its memory."""
    lines = ["| service | on a processor ms | waits for one ms | memory MB |", "|---|---|---|---|"]
    for name, took in watched.services.items():
        lines.append(
            f"| {name} | {took.running_ms:.2f} | {took.waiting_ms:.2f} | {took.memory_mb:.0f} |"
        )
    return "\n".join(lines)


def rounds_table(rounds: list[Round]) -> str:
    """Markdown: the rounds and the median of their ratios."""
    lines = ["| ticks | processes ms | one process ms | ratio |", "|---|---|---|---|"]
    lines += [
        f"| {one.ticks} | {one.deployed_ms:.2f} | {one.local_ms:.2f} | {one.ratio:.2f} |"
        for one in rounds
    ]
    return "\n".join([*lines, f"| median | | | {median(rounds):.2f} |"])


def median(rounds: list[Round]) -> float:
    """Of the ratios."""
    return statistics.median(one.ratio for one in rounds)


def main() -> None:
    """Run the rounds and print them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=0, help="of the episode")
    parser.add_argument("--rounds", type=int, default=3, help="episodes each way")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/speed.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rounds = []
        for index in range(arguments.rounds):
            print(f"bench.loop: round {index + 1} of {arguments.rounds}", file=sys.stderr)
            rounds.append(run_round(arguments.seed, Path(folder) / str(index)))
        print("bench.loop: where a tick goes", file=sys.stderr)
        watched = run_watched(arguments.seed, Path(folder) / "watched")
    tables = {
        "loop": rounds_table(rounds),
        "tick": ticks_table(watched),
        "services": services_table(watched),
    }
    if arguments.write:
        for name, table in tables.items():
            write_table(name, table)
    if arguments.json:
        rows = [asdict(one) | {"ratio": one.ratio} for one in rounds]
        print(json.dumps({"rounds": rows, "ratio": median(rounds), "watched": asdict(watched)}))
        return
    print("\n\n".join(tables.values()))
    print(f"\nbench.loop: median ratio {median(rounds):.2f}")


if __name__ == "__main__":
    main()
