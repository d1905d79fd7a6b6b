"""One episode of the campaign in the simulator again, tick by tick the same.

    .venv/bin/python -m bench.soundness.episode panda_mobile base-cycles 10003

Robot, attack and seed are what the campaign tells with each breach; they decide every row that is
asked for, so the same gate and the same limits lead to the same motion. Prints the first breach of
each rule, the worst, and what was refused. Exits 1 on a breach. ``--trace FILE`` writes a line of
JSON for each tick: positions, velocities, and what each part was told.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from bench.soundness.demonstrations import SKILLS
from bench.soundness.gate_loop import GateLoop
from bench.soundness.simulated_campaign import Simulated, SimulatedCampaign
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.soundness.episode",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("robot", choices=SKILLS)
    parser.add_argument("attack")
    parser.add_argument("seed", type=int)
    parser.add_argument("--trace", type=Path, help="a file for what happened in each tick")
    arguments = parser.parse_args()
    loop = TracedLoop(DrivenRobot(arguments.robot))
    try:
        campaign = SimulatedCampaign(loop)
        campaign.episode(arguments.attack, arguments.seed)
    finally:
        loop.close()
    if arguments.trace:
        arguments.trace.write_text("".join(map(_line, loop.ticks)), encoding="utf-8")
    print(_text(campaign.found))
    return 1 if campaign.found.breaches else 0


class TracedLoop(GateLoop[DrivenRobot]):
    """Keeps every tick of its newest episode."""

    ticks: list[Tick]

    def __init__(self, driven: DrivenRobot) -> None:
        self.ticks = []
        super().__init__(driven)

    def _next(self, done: Tick, is_heard: bool = True) -> None:
        self.ticks.append(done)
        super()._next(done, is_heard)


def _text(found: Simulated) -> str:
    return "\n".join(
        [
            f"{found.rows} rows executed, {found.held} ticks held, {found.chunks} chunks; "
            f"refused {dict(found.refused)}, truncated {dict(found.truncated)}, "
            f"stops {dict(found.stops)}",
            f"ticks in breach {dict(found.breaches)}; of them idle {dict(+found.idle)}",
            "smallest margins: "
            + ", ".join(f"{rule} {room:.4f}" for rule, room in found.worst.items()),
            *found.told,
        ]
    )


def _line(tick: Tick) -> str:
    told = {
        part: {"mode": one.mode.yaml_name, "values": one.values.tolist()}
        for part, one in tick.commands.items()
    }
    line = {
        "positions": tick.after.positions.tolist(),
        "velocities": tick.after.velocities.tolist(),
        "told": told,
    }
    return json.dumps(line) + "\n"


if __name__ == "__main__":
    sys.exit(main())
