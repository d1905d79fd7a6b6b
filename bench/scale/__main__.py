"""How many robots one router carries: 1 to 32, each with a HAL at 50 Hz, a real gate and a feeder.

    .venv/bin/python -m bench.scale [--robots 1,4,16] [--seconds N] [--rounds N] [--json] [--write]

A robot is a so101 of the shipped HAL without physics, its gate, and a client that sends a chunk of
16 rows every 8 ticks. All are clients of one router, closed: certificates, TLS and access rules of
each robot. In turn, by rounds: ordinary processes; HAL and gate with a real-time priority, as long
as these leave time for others; and dora-rs: as many robots of three nodes that pass messages as
large and as many (but for statuses) and compute nothing. Times of ticks are from the HAL's log.

Aims, of each way's most robots and one: processor time a tick of a robot, its share of the router
included, at most 1.15; the 99th percentile of how far a tick is off its period at most 4. Robots
of which more than 5 % of the ticks held or never came are not carried: that is a miss, and has no
ratio. Where a machine is full aims are missed: --json says how full it was.

dora-rs lives in an environment of its own (build/dora, or DORA=FOLDER); how to make it is said
where it is absent. --write puts the table into docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from textwrap import fill

from bench.image_move.dora import VERSION, why_absent
from bench.page import Write, write_table
from bench.scale.dora import dora
from bench.scale.fleet import fairlead, traffic
from bench.scale.measured import Found, Window, found
from bench.scale.thousand import fleet_text, traffic_table
from bench.scale.traffic import Sent
from fairlead.deploy.scheduling import realtime_words
from fairlead.errors import ConfigError, FairleadError, ServiceError

CPU_AIM, TICK_AIM = 1.15, 4.0
IDLE_MOST = 0.05
"""Of the ticks of robots that are carried: held, or none came."""
ROBOTS = (1, 8, 16, 32)
OURS, REALTIME, THEIRS = "fairlead", "fairlead, real-time", f"dora-rs {VERSION}"
PRIORITY = 20
MOST_REALTIME = 4 * (os.cpu_count() or 1)
"""Robots: a HAL and a gate of 50 Hz take an eighth of a processor."""

Way = Callable[[int, float, Path], Window]
Failed = Mapping[tuple[int, str], str]
"""Robots and way of what could not be measured, and why."""


def ways_here(messages: Mapping[str, Sent]) -> Mapping[str, Way]:
    """Those that this machine permits and has; of the others it is said why not."""
    ways: dict[str, Way] = {OURS: partial(fairlead, 0)}
    try:
        realtime_words("hal", PRIORITY)
        ways[REALTIME] = partial(fairlead, PRIORITY)
    except ConfigError as error:
        print(f"bench.scale: skipped: {error}", file=sys.stderr)
    if absent := why_absent():
        print(f"bench.scale: skipped: {absent}", file=sys.stderr)
    else:
        ways[THEIRS] = partial(dora, messages)
    return ways


def measure(
    ways: Mapping[str, Way], robots: Sequence[int], rounds: int, seconds: float, folder: Path
) -> tuple[list[Found], Failed]:
    """Every way and number of robots, by turns, so that what else the machine does meets them all.

    What failed once is not tried again.
    """
    windows: dict[tuple[int, str], list[Window]] = {}
    failed: dict[tuple[int, str], str] = {}
    for number in range(rounds):
        for count in robots:
            for name, way in ways.items():
                one = count, name
                if one in failed or (name == REALTIME and count > MOST_REALTIME):
                    continue
                text = f"bench.scale: round {number + 1} of {rounds}: {name}, {count} robots"
                print(text, file=sys.stderr)
                scene = folder / f"{number}-{count}-{name}".replace(" ", "-")
                try:
                    windows.setdefault(one, []).append(way(count, seconds, scene))
                except (ServiceError, OSError) as error:  # a process ended, or would not start
                    print(f"bench.scale: {name}, {count} robots: {error}", file=sys.stderr)
                    failed[one] = str(error).splitlines()[0]
    kept = [found(name, each) for (_, name), each in windows.items() if each]
    return kept, failed


def ratios(one: Found, every: Sequence[Found]) -> tuple[float, float]:
    """Of the same way with the fewest robots: processor time a tick, 99th percentile of a tick."""
    least = min((other for other in every if other.way == one.way), key=lambda o: o.robots)
    return one.cpu_ms / least.cpu_ms, one.error_ms[1] / least.error_ms[1]


def is_carried(one: Found) -> bool:
    """Whether its robots move; those that stand still cost little."""
    return max(one.held, one.lost) <= IDLE_MOST


def table(every: Sequence[Found], failed: Failed) -> str:
    """In Markdown."""
    lines = [
        f"| robots | processor ms a tick, of 1 (aim {CPU_AIM}) "
        f"| tick error p99 ms, of 1 (aim {TICK_AIM:g}) | state to lease p99 ms |",
        "|---|---|---|---|",
    ]
    idle = []
    for one in every:
        cpu, tick = ratios(one, every)
        cells = [f"{one.robots}: {one.way}", f"{one.cpu_ms:.2f}, {cpu:.2f}"]
        cells += [f"{one.error_ms[1]:.2f}, {tick:.1f}", f"{one.lease_ms[1]:.2f}"]
        if is_carried(one):
            lines.append(f"| {' | '.join(cells)} |")
        else:
            idle.append(f"{cells[0]} ({one.lost:.0%} of ticks lost, {one.held:.0%} held)")
    idle += [f"{count}: {way} ({why})" for (count, way), why in failed.items()]
    return "\n".join([*lines, "", fill(f"Not carried: {'; '.join(idle)}.", 120)] if idle else lines)


def misses(every: Sequence[Found]) -> list[str]:
    """Aims that were missed, in words."""
    ours = sorted((one for one in every if one.way in (OURS, REALTIME)), key=lambda one: one.robots)
    most = {one.way: one for one in ours}
    idle = [
        f"{one.robots} robots, {one.way}: not carried: {one.held:.0%} of the ticks held, "
        f"{one.lost:.0%} never came, at most {IDLE_MOST:.0%} each"
        for one in ours
        if not is_carried(one)
    ]
    return idle + [
        f"{what} of {one.robots} robots, {way}: {ratio:.2f} of the fewest, aim {aim}"
        for way, one in most.items()
        if is_carried(one)
        for what, ratio, aim in zip(
            ("processor time", "p99 of a tick"),
            ratios(one, every),
            (CPU_AIM, TICK_AIM),
            strict=True,
        )
        if ratio > aim
    ]


def numbers(text: str) -> list[int]:
    """Robots, as ``1,4,16``."""
    robots = sorted({int(word) for word in text.split(",")})
    if robots[0] < 1:
        raise ValueError
    return robots


def arguments() -> argparse.Namespace:
    """From the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.scale",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="example: .venv/bin/python -m bench.scale --robots 1,4 --seconds 5 --rounds 1",
    )
    parser.add_argument("--robots", type=numbers, default=list(ROBOTS), help="how many, each")
    parser.add_argument("--seconds", type=float, default=10.0, help="of each measurement")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put the table into docs/speed.md")
    args = parser.parse_args()
    if args.seconds <= 0 or args.rounds < 1:
        parser.error(f"expected time and rounds, got {args.seconds:g} s, {args.rounds} rounds")
    return args


def main() -> int:
    """Measure and print; 1 if an aim is missed."""
    args = arguments()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print("bench.scale: what one robot sends", file=sys.stderr)
        messages = traffic(folder / "traffic")
        every, failed = measure(ways_here(messages), args.robots, args.rounds, args.seconds, folder)
    ours = [one for one in every if one.way == OURS]
    if not ours:
        return 1
    tables = {"traffic": traffic_table(messages), "fleet": fleet_text(messages, ours)}
    if args.json:
        sent = {key: asdict(one) for key, one in messages.items()}
        print(json.dumps({"sent": sent, "found": [asdict(one) for one in every]}))
    else:
        print("\n\n".join((table(every, failed), *tables.values())))
    if args.write:
        write_table("scale", table(every, failed))
    missed = misses(every)
    for text in missed:
        print(f"bench.scale: missed: {text}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    try:
        raise SystemExit(main())
    except FairleadError as error:
        raise SystemExit(f"ERROR bench.scale: {error}") from None
