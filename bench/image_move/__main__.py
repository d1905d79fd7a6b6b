"""How long pictures take from a camera's process to an array in another, at 30 Hz.

    .venv/bin/python -m bench.image_move [--ticks N] [--rounds N] [--json] [--write]

Two pictures of 224 x 224 a tick, and one of 640 x 480, RGB. In one run and by turns: through
fairlead's bus on one host, through dora-rs, through Zenoh over TCP as between hosts, and the floor:
a ring of shared memory with an eventfd, one copy in and none out. From just before the first
picture is handed over until the last one's first and last pixels were read from an array.

Aims: at most 1.35 of the floor, at most dora-rs's. dora-rs lives in an environment of its own
(build/dora, or DORA=FOLDER); how to make it is said where it is absent. --write puts the table
into docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bench.image_move import ways
from bench.image_move.dora import VERSION, dora, why_absent
from bench.image_move.pictures import CASES, WARM_UP, Case
from bench.page import Write, write_table

FLOOR_AIM, DORA_AIM = 1.35, 1.0

Way = Callable[[Case, int], list[float]]
Found = dict[str, list[float]]
"""By way, the latencies [us] of all rounds."""


def measure(case: Case, ticks: int, rounds: int, known: Mapping[str, Way]) -> Found:
    """Every way, by turns, so that what else the machine does meets them all."""
    found: Found = {name: [] for name in known}
    for number in range(rounds):
        for name, way in known.items():
            text = f"bench.image_move: {case.name}, round {number + 1} of {rounds}: {name}"
            print(text, file=sys.stderr)
            found[name] += way(case, ticks)
    return found


def told(case: Case, found: Found, sent: int) -> dict[str, object]:
    """Medians, 90th percentiles, ratios, and how many ticks were lost."""
    medians = {name: float(np.median(all_us)) for name, all_us in found.items() if all_us}
    return {
        "case": case.name,
        "sent": sent,
        "p50_us": medians,
        "p90_us": {name: float(np.percentile(found[name], 90)) for name in medians},
        "lost": {name: sent - len(all_us) for name, all_us in found.items()},
        "of_floor": _ratio(medians, "floor"),
        "of_dora": _ratio(medians, "dora"),
    }


def _ratio(medians: Mapping[str, float], other: str) -> float | None:
    ours = medians.get("fairlead")
    return ours / medians[other] if ours and other in medians else None


def table(documents: Sequence[dict[str, object]]) -> str:
    """In Markdown."""
    lines = [
        f"| p50, p90 us; fairlead's p50 of it | fairlead | floor (aim {FLOOR_AIM}) "
        f"| dora-rs {VERSION} (aim {DORA_AIM}) |",
        "|---|---|---|---|",
    ]
    for one in documents:
        cells = [_cell(one, "fairlead"), _cell(one, "floor", "of_floor")]
        cells += [_cell(one, "dora", "of_dora")]
        lines.append(f"| {one['case']} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _cell(one: Mapping[str, object], way: str, share: str = "") -> str:
    p50, p90, lost = (one[key] for key in ("p50_us", "p90_us", "lost"))
    assert isinstance(p50, dict) and isinstance(p90, dict) and isinstance(lost, dict)
    if way not in p50:
        return "not here"
    missing = f", {lost[way]} of {one['sent']} lost" if lost[way] else ""
    ratio = f"; {one[share]:.2f}" if share else ""
    return f"{p50[way]:.0f}, {p90[way]:.0f}{missing}{ratio}"


def misses(documents: Sequence[dict[str, object]]) -> list[str]:
    """Aims that were missed, in words."""
    return [
        f"{one['case']}: {ratio:.2f} of {what}, aim {aim}"
        for one in documents
        for key, what, aim in (
            ("of_floor", "the floor", FLOOR_AIM),
            ("of_dora", "dora-rs", DORA_AIM),
        )
        if isinstance(ratio := one[key], float) and ratio > aim
    ]


def main() -> int:
    """Measure and print; 1 if an aim is missed."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.image_move",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--ticks", type=int, default=150, help=f"of a round, above {WARM_UP}")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put the table into docs/speed.md")
    args = parser.parse_args()
    if args.ticks <= WARM_UP or args.rounds < 1:
        got = f"{args.ticks} and {args.rounds}"
        parser.error(f"expected more than {WARM_UP} ticks and at least 1 round, got {got}")
    known: dict[str, Way] = {"floor": ways.floor, "fairlead": ways.fairlead, "zenoh": ways.zenoh}
    absent = why_absent()
    if absent:
        print(f"bench.image_move: skipped: {absent}", file=sys.stderr)
    else:
        known["dora"] = dora
    sent = args.rounds * (args.ticks - WARM_UP)
    documents = [told(case, measure(case, args.ticks, args.rounds, known), sent) for case in CASES]
    print(json.dumps(documents) if args.json else table(documents))
    if args.write:
        write_table("image_move", table(documents))
    missed = misses(documents)
    for text in missed:
        print(f"bench.image_move: missed: {text}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
