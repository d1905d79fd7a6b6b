"""What the processes cost: a lockstep episode through them, beside the same steps in one.

Both take turns, an answer of the policy with its rows at a time (no cameras), so that what the
machine does to one it does to the other. The services run as ordinary processes, then HAL and
gate with a real-time priority.

    .venv/bin/python -m bench.loop [--seed 0] [--rounds 3] [--json] [--write]

Prints milliseconds per tick of each and the median ratio of a turn; then, of one more episode
with a listener on the robot's bus, where a tick goes and what each process took. --write puts the
tables into docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import yaml

from bench.equipment.turns import Turns
from bench.page import Write, write_table
from bench.tick_watch import Spent, TickWatch, spent
from fairlead.deploy.deployment import load_deployment
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.skill.manifest import load_skill
from fairlead_tools.parity.local_episode import LocalEpisode
from fairlead_tools.supervisor.scratch import (
    Scratch,
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

SKILL = "oracle-counter-to-cabinet"
SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
DEADLINE_TICKS = 800
PRIORITIES = {"ordinary": 0, "real-time": 20}
"""Of HAL and gate."""


@dataclass(frozen=True)
class Turn:
    """An answer of the policy and its rows each way: wall time per tick [ms]."""

    deployed_ms: float
    local_ms: float

    @property
    def ratio(self) -> float:
        """How often the in-process turn fits into the one through the processes."""
        return self.deployed_ms / self.local_ms


@dataclass(frozen=True)
class Round:
    """One episode each way, in turns."""

    priority: str
    turns: Sequence[Turn]

    @property
    def deployed_ms(self) -> float:
        """Per tick, through the processes; median."""
        return statistics.median(turn.deployed_ms for turn in self.turns)

    @property
    def local_ms(self) -> float:
        """Per tick, in one process; median."""
        return statistics.median(turn.local_ms for turn in self.turns)

    @property
    def ratio(self) -> float:
        """Median of the turns'."""
        return statistics.median(turn.ratio for turn in self.turns)


def prepare(folder: Path, priority: int, access: Literal["closed", "open"] = "closed") -> Scratch:
    """A copy of the deployment, in lockstep, with a real-time priority of HAL and gate."""
    original = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    for service in original["services"].values():
        if service["run"] in ("hal_sim", "safety"):
            service["realtime_priority"] = priority
    folder.mkdir()
    source = folder / SOURCE.name
    source.write_text(yaml.safe_dump(original), encoding="utf-8")
    options = ScratchOptions(pacing="lockstep", access=access)
    return make_scratch(source, folder / "robot", options)


def run_round(seed: int, folder: Path, priority: str) -> Round:
    """One episode through the processes and in this one, in turns until the first ends."""
    scratch = prepare(folder, PRIORITIES[priority])
    os.environ[SKILLS_VARIABLE] = str(folder)
    with closing(Turns(folder, SKILL)) as turns, scratch_robot(scratch) as robot:
        return Round(priority, take_turns(robot, turns, seed))


def take_turns(robot: ScratchRobot, turns: Turns, seed: int) -> Sequence[Turn]:
    """Reset both, then one turn each until the robot's goal ends."""
    reset = robot.client.reset_episode(seed)
    robot.client.arm()
    deployment, skill = load_deployment(SOURCE), load_skill(SKILL)
    options = GoalOptions(turns.skill, deadline_ticks=DEADLINE_TICKS)
    taken: list[Turn] = []
    with (
        closing(LocalEpisode(deployment, skill, seed, reset)) as local,
        ThreadPoolExecutor(1) as thread,
    ):
        goal = thread.submit(run_goal, robot.client, options)
        asked = turns.wait_asked(goal.done)
        while asked:
            began_s = time.monotonic()
            local.act()
            between_s = time.monotonic()
            turns.let_go()
            asked = turns.wait_asked(goal.done)
            ended_s = time.monotonic()
            if asked:
                ms = 1e3 / skill.execute_steps
                taken.append(Turn((ended_s - between_s) * ms, (between_s - began_s) * ms))
        result = goal.result().result
    assert result is not None and result.outcome == "succeeded", f"the goal failed: {result}"
    return taken


@dataclass(frozen=True)
class Watched:
    """One more episode: where its ticks go [ms], and what each service took a tick."""

    segments: dict[str, dict[str, float]]
    services: dict[str, Spent]


def run_watched(seed: int, folder: Path) -> Watched:
    """An episode through the processes with a listener, which is left out of the ratio."""
    scratch = prepare(folder, 0)
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


def services_text(watched: Watched) -> str:
    """What each service took a tick on a processor, and its memory."""
    found = (
        f"{name} {took.running_ms:.2f} ms, {took.memory_mb:.0f} MB"
        for name, took in watched.services.items()
    )
    return f"{'; '.join(found)}."


def rounds_text(rounds: Sequence[Round]) -> str:
    """For each priority the range of the rounds, and the median of their ratios."""
    lines = ["Milliseconds in all processes, in one; ratio:", ""]
    for priority in PRIORITIES:
        ours = [one for one in rounds if one.priority == priority]
        deployed, local, ratio = (
            f"{min(numbers):.2f} to {max(numbers):.2f}"
            for numbers in (
                [one.deployed_ms for one in ours],
                [one.local_ms for one in ours],
                [one.ratio for one in ours],
            )
        )
        middle = f"{median(rounds, priority):.2f}"
        lines.append(f"- {priority}: {deployed}, {local}; {middle} ({ratio})")
    return "\n".join(lines)


def median(rounds: Sequence[Round], priority: str) -> float:
    """Of the ratios of one priority's rounds."""
    return statistics.median(one.ratio for one in rounds if one.priority == priority)


def main() -> None:
    """Run the rounds and print them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=0, help="of the episode")
    parser.add_argument("--rounds", type=int, default=3, help="episodes each way and priority")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put the tables into docs/speed.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rounds = []
        for index in range(arguments.rounds):
            for priority in PRIORITIES:
                said = f"round {index + 1} of {arguments.rounds}, {priority}"
                print(f"bench.loop: {said}", file=sys.stderr)
                scene = Path(folder) / f"{priority}{index}"
                rounds.append(run_round(arguments.seed, scene, priority))
        print("bench.loop: where a tick goes", file=sys.stderr)
        watched = run_watched(arguments.seed, Path(folder) / "watched")
    tables = {
        "loop": rounds_text(rounds),
        "tick": ticks_table(watched),
        "services": services_text(watched),
    }
    if arguments.write:
        for name in ("loop", "services"):
            write_table(name, tables[name])
    medians = {priority: median(rounds, priority) for priority in PRIORITIES}
    if arguments.json:
        rows = [asdict(one) | {"ratio": one.ratio} for one in rounds]
        print(json.dumps({"rounds": rows, "ratio": medians, "watched": asdict(watched)}))
        return
    print("\n\n".join(tables.values()))
    said = ", ".join(f"{priority} {ratio:.2f}" for priority, ratio in medians.items())
    print(f"\nbench.loop: median ratio: {said}")


if __name__ == "__main__":
    main()
