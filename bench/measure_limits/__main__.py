"""Measures what a simulated robot does with full-scale commands, and in its demonstrations.

    .venv/bin/python -m bench.measure_limits panda_mobile [--random 1600] [--episodes 20] [--json]

Drives the robot's HAL backend itself, without gate and processes: every part and mode axis by axis,
in random directions alone, all parts together, the scripted demonstrations, and stops from full
scale. Seeds are fixed: the same machine prints the same numbers. The limits that robot.yaml calls
measured are these, with the margin it tells. From the tick in which the robot touches something, or
one of its arm joints is at its end, until the next reset only efforts are noted; demonstrations
count whole. A residual is the distance of a measured motion to everything between the gain's
shares of the row before and of the row itself.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from bench.measure_limits.driven_robot import ROBOTS
from bench.measure_limits.measurement import Amount, measure
from bench.measure_limits.report import document


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.measure_limits",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("robot", choices=ROBOTS)
    parser.add_argument("--random", type=int, default=1600, help="ticks of each random drive")
    parser.add_argument("--episodes", type=int, default=20, help="demonstrations")
    parser.add_argument("--stops", type=int, default=18, help="drives that end in a stop")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    amount = Amount(arguments.random, arguments.episodes, arguments.stops)
    found = document(measure(arguments.robot, amount, _say))
    print(json.dumps(found, indent=1) if arguments.json else "\n".join(_lines(found)))


def _say(what: str) -> None:
    print(f"measure_limits: {what}", file=sys.stderr, flush=True)


def _lines(found: dict[str, Any], head: str = "") -> list[str]:
    """One line for each innermost group of numbers."""
    inner = {key: value for key, value in found.items() if isinstance(value, dict)}
    plain = [f"{key} {value}" for key, value in found.items() if key not in inner]
    lines = [f"{head}{', '.join(plain)}"] if plain else []
    for key, value in inner.items():
        lines += _lines(value, f"{head}{key}: ")
    return lines


if __name__ == "__main__":
    main()
