"""The results as the tables of docs/soundness.md, and as one document."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.soundness.arena import RULES
from bench.soundness.results import Results
from bench.soundness.simulated_campaign import SPEED

BEGIN = "<!-- from here on written by: python -m bench.soundness --write -->"


def document(results: Sequence[Results]) -> dict[str, Any]:
    """Every number, robot by robot."""
    found: dict[str, Any] = {}
    for one in results:
        found[one.robot] = {
            name: _plain(asdict(getattr(one, name)))
            for name in ("kinematic", "simulated", "usability")
        }
    return found


def tables(results: Sequence[Results], command: str, day: str) -> str:
    """Two tables, a list and what was told, as Markdown."""
    return "\n".join(
        [
            f"Measured on {day} by `{command}`.",
            "",
            "## Followed by a second model",
            "",
            *_head("robot", "chunks", "refused", "rows that acted", "breaches", *RULES),
            *(_kinematic(one) for one in results),
            "",
            "## Executed in the simulator",
            "",
            *_head("robot", "rows executed", "stops", "ticks in breach", *RULES, SPEED),
            *(_simulated(one) for one in results),
            "",
            "## Good demonstrations",
            "",
            "Episodes that succeeded, and what the gate did not release whole:",
            "",
            *(_usability(one) for one in results),
            "",
            *_told(results),
        ]
    )


def write(path: Path, text: str) -> None:
    """Replace what stands behind the mark in a document."""
    head = path.read_text(encoding="utf-8").split(BEGIN)[0]
    path.write_text(f"{head}{BEGIN}\n\n{text.rstrip()}\n", encoding="utf-8")


def _kinematic(one: Results) -> str:
    found = one.kinematic
    return _line(
        one.robot,
        f"{found.chunks:,}",
        f"{found.refused.total():,}",
        f"{found.rows:,}",
        _names(found.breaches),
        *(_room(found.worst[rule]) for rule in RULES),
    )


def _simulated(one: Results) -> str:
    found = one.simulated
    return _line(
        one.robot,
        f"{found.rows:,}",
        _names(found.stops),
        _names(found.breaches),
        *(_room(found.worst[rule]) for rule in (*RULES, SPEED)),
    )


def _usability(one: Results) -> str:
    found = one.usability
    faults = {
        "refused": found.refused.total(),
        "truncated": found.truncated.total(),
        "cut off": found.cut.total(),
        "stops": found.stops.total(),
    }
    said = [f"{count:,} {name}" for name, count in faults.items() if count]
    done = f"{found.succeeded} of {found.episodes}" if found.succeeded else "no task"
    return f"- {one.robot}: {done}, {found.chunks:,} chunks, {', '.join(said) or 'all released'}"


def _told(results: Sequence[Results]) -> list[str]:
    """What the second model could not follow; each robot's first breach, without its row."""
    unsolved = [
        f"Rows of {one.robot} that the second model did not solve: {one.kinematic.not_reached:,}"
        for one in results
        if one.kinematic.not_reached
    ]
    return unsolved + [
        f"First breach of {one.robot}: {line.partition(', row')[0]}"
        for one in results
        for told in (one.kinematic.told, one.simulated.told, one.usability.told)
        for line in told[:1]
    ]


def _head(*names: str) -> tuple[str, str]:
    return _line(*names), "|---" * len(names) + "|"


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _names(counter: Counter[str]) -> str:
    return ", ".join(f"{count:,} {name}" for name, count in counter.most_common()) or "0"


def _room(room: float) -> str:
    """The smallest margin; of a rule that the robot does not have none."""
    return f"{round(room, 4) + 0.0:.4f}" if room < math.inf else "-"


def _plain(value: Any) -> Any:
    """JSON has no infinity, and its keys are words."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, float) and value == float("inf"):
        return None
    return value
