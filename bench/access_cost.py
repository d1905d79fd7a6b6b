"""What access control costs: a closed gate beside an open one, a closed robot beside an open one.

Both take turns with the same chunks, or with an answer of the policy and its rows, so that what
the machine does to one it does to the other; who comes first changes each time. Processes differ by
chance as long as they live, so all begin anew a few times, and the ratio of each time is printed.

    .venv/bin/python -m bench.access_cost [--count 2000]

Prints medians and ratios: of the hop from candidate to SafeChunk, back to back and at 20 Hz,
and of a tick of the loop in lockstep.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.equipment.gate_scene import Scene
from bench.equipment.turns import Turns
from bench.gate_hop import CASES, Arrival, socket_in
from bench.loop import DEADLINE_TICKS, SKILL, prepare
from fairlead.messages import encode
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import SKILLS_VARIABLE, gate_config
from fairlead.skill.manifest import load_skill
from fairlead_tools.supervisor.scratch import scratch_robot

AIM = 1.03
WARM_UP = 100
PAUSE_S = 0.025  # two in a period of 20 Hz
SEED = 0
ROUNDS = 5
Pairs = NDArray[np.float64]
"""A row for each pair: open, closed [us]."""


class Gate:
    """A gate with a claim on its robot's arm."""

    def __init__(self, folder: Path, closed: bool) -> None:
        self.case = CASES[0]
        config = gate_config(self.case.robot, "sim")
        listen = socket_in(folder.parent, folder.name)
        self.scene = Scene(config, folder, robot=self.case.robot, closed=closed, listen=listen)
        self.scene.ready_to_move()
        self.scene.safe.close()  # its work would count as the gate's
        self.safe = Arrival(self.scene.bus, self.scene.keys.safe("runner"))

    def hop_us(self, pause_s: float = 0.0) -> float:
        """One chunk of one row, from just before it is sent to its released row."""
        chunk = self.scene.chunk(1, parts=(self.case.part(self.scene, 1),))
        time.sleep(pause_s)
        taken_us = self.safe.after(self.scene.send_bytes, encode(chunk))
        verdict = self.scene.verdicts.wait_for(lambda m: m.seq == chunk.seq)
        self.scene.acted_on(verdict, 0)
        return taken_us


def pair_of(taken_us: Sequence[Callable[[], float]], number: int) -> list[float]:
    """Open and closed; the closed one comes first in each pair of an odd number."""
    found = [0.0, 0.0]
    for at in (number % 2, 1 - number % 2):
        found[at] = taken_us[at]()
    return found


def hops_us(folder: Path, count: int, pause_s: float) -> Pairs:
    """Pairs of hops, with a pause before each."""
    with ExitStack() as stack:
        folder.mkdir()
        gates = [Gate(folder / name, name == "closed") for name in ("open", "closed")]
        for gate in gates:
            stack.callback(gate.scene.close)
        for gate in gates * WARM_UP:
            gate.hop_us()
        hops = [partial(gate.hop_us, pause_s) for gate in gates]
        return np.array([pair_of(hops, number) for number in range(count)])


class Robot:
    """A robot in lockstep whose policy answers only when it may."""

    def __init__(self, folder: Path, stack: ExitStack, closed: bool) -> None:
        scratch = prepare(folder, 0, "closed" if closed else "open")
        self.turns = stack.enter_context(closing(Turns(folder, SKILL)))
        os.environ[SKILLS_VARIABLE] = str(folder)
        self.client = stack.enter_context(scratch_robot(scratch)).client
        self.client.reset_episode(SEED)
        self.client.arm()
        self._goal: Future[Progress]

    def start(self, thread: ThreadPoolExecutor) -> bool:
        """Begin the goal; whether it has asked its policy."""
        options = GoalOptions(self.turns.skill, deadline_ticks=DEADLINE_TICKS)
        self._goal = thread.submit(run_goal, self.client, options)
        return self.turns.wait_asked(self._goal.done)

    def turn_us(self) -> float:
        """An answer of the policy and its rows; 0 once the goal has ended."""
        began_s = time.monotonic()
        self.turns.let_go()
        asked = self.turns.wait_asked(self._goal.done)
        return 1e6 * (time.monotonic() - began_s) if asked else 0.0


def ticks_us(folder: Path) -> Pairs:
    """Pairs of times per tick, of the same episode."""
    folder.mkdir()
    with ExitStack() as stack:
        robots = []
        for name in ("open", "closed"):
            robots.append(Robot(folder / f"loop {name}", stack, name == "closed"))
        pairs: list[list[float]] = []
        with ThreadPoolExecutor(2) as thread:
            going = all(robot.start(thread) for robot in robots)
            while going:
                pairs.append(pair_of([robot.turn_us for robot in robots], len(pairs)))
                going = all(pairs[-1])
            for robot in robots:
                robot.turns.close()
    return np.array(pairs[:-1]) / load_skill(SKILL).execute_steps


def row(what: str, rounds: Sequence[Pairs]) -> str:
    """A line of the table."""
    both = np.median(np.concatenate(rounds), axis=0)
    ratios = sorted(float(np.median(pairs[:, 1] / pairs[:, 0])) for pairs in rounds)
    each = " ".join(f"{one:.2f}" for one in ratios)
    return f"| {what} | {both[0]:.0f} | {both[1]:.0f} | {both[1] / both[0]:.2f} | {each} |"


def main() -> None:
    """Both, and print them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2000, help="chunks of each gate")
    arguments = parser.parse_args()
    lines = [
        f"| what | open us | closed us | ratio (aim {AIM}) | of each of {ROUNDS} starts |",
        "|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        count = arguments.count // ROUNDS
        parts: Sequence[tuple[str, Callable[[Path], Pairs]]] = (
            ("hop, back to back", lambda own: hops_us(own, count, 0.0)),
            ("hop, at 20 Hz", lambda own: hops_us(own, count // 10, PAUSE_S)),
            ("tick of the loop", ticks_us),
        )
        for at, (what, measure) in enumerate(parts):
            rounds = [measure(folder / f"{at}{number}") for number in range(ROUNDS)]
            lines.append(row(what, rounds))
    lines += ["", f"load average {os.getloadavg()[0]:.1f}"]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
