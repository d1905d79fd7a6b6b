"""How much of what a checkpoint might say is refused: random vectors of 12 numbers, by scale.

    .venv/bin/python -m bench.soundness.checkpoint_vectors [--seeds 5] [--scale 0.15 ...]

The mobile robot in its simulator. Each chunk has 16 rows, of which 8 are used before the next; arm
and base are uniform within the scale, gripper and composite switch at either end. Prints one line
for each scale.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.equipment.expert_episode import commands
from bench.soundness.chunk_rows import Row
from bench.soundness.gate_loop import GateLoop
from fairlead.messages import Outcome
from fairlead_tools.measure.driven_robot import DrivenRobot

ROWS, USED, TICKS = 16, 8, 160
SCALES = (0.15, 0.3, 1.0)
GRIPPER, TORSO, SWITCH = 6, 10, 11


@dataclass
class Answers:
    """chunks: asked for. rows: executed; held: ticks without. codes: by what was cut or refused."""

    chunks: int = 0
    refused: int = 0
    truncated: int = 0
    rows: int = 0
    held: int = 0
    codes: Counter[int] = field(default_factory=Counter)


def ask(loop: GateLoop[DrivenRobot], scale: float, seeds: Sequence[int]) -> Answers:
    """One episode for each seed."""
    found = Answers()
    for seed in seeds:
        rng = np.random.default_rng(seed)
        loop.begin(seed)
        until = 0  # rows in use act before this tick
        while loop.tick <= TICKS and not loop.stop_cause:
            if loop.undecided or loop.tick >= until:
                until = loop.tick + _propose(loop, _rows(rng, scale), found)
            done = loop.advance("checkpoint")
            if done is not None:
                found.rows += bool(done.commands)
                found.held += not done.commands
    return found


def _propose(loop: GateLoop[DrivenRobot], rows: Sequence[Row], found: Answers) -> int:
    """How many rows to use before the next chunk."""
    verdict = loop.propose(rows)
    found.chunks += 1
    if verdict.outcome == Outcome.RELEASED:
        return USED
    found.codes[verdict.code] += 1
    if verdict.outcome == Outcome.TRUNCATED:
        found.truncated += 1
        return min(USED, verdict.released_last + 1 - loop.tick)
    found.refused += 1
    return 1


def _rows(rng: np.random.Generator, scale: float) -> list[Row]:
    vectors = rng.uniform(-scale, scale, (ROWS, 12)).astype(np.float32)
    vectors[:, TORSO] = 0.0
    for index in (GRIPPER, SWITCH):
        vectors[:, index] = np.where(rng.random(ROWS) < 0.5, -1.0, 1.0)
    return [commands(vector) for vector in vectors]


def main() -> None:
    """Ask and print."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.soundness.checkpoint_vectors",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=int, default=5, help="episodes (default: %(default)s)")
    parser.add_argument("--scale", type=float, action="append", help="only this one; repeatable")
    arguments = parser.parse_args()
    loop = GateLoop(DrivenRobot("panda_mobile"))
    try:
        for scale in arguments.scale or SCALES:
            found = ask(loop, scale, range(arguments.seeds))
            codes = ", ".join(f"{count} G{code:03d}" for code, count in found.codes.most_common())
            cut, refused = (
                f"{count} ({count / found.chunks:.0%})"
                for count in (found.truncated, found.refused)
            )
            rows = f"{found.rows} of {found.rows + found.held}"
            print(f"| {scale} | {found.chunks} | {cut} | {refused} | {codes or '-'} | {rows} |")
    finally:
        loop.close()


if __name__ == "__main__":
    main()
