"""The results as the table of docs/soundness.md, and as one document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.soundness.results import Results
from bench.soundness.usability import Usability

COLUMNS = (
    *("robot", "chunks followed", "refused", "rows that acted", "breaches"),
    *("rows executed", "stops", "ticks in breach"),
    *("demonstrations", "not released whole"),
)
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
    """A table and what was told, as Markdown."""
    return "\n".join(
        [
            f"Measured on {day} by `{command}`.",
            "",
            _line(*COLUMNS),
            "|---" * len(COLUMNS) + "|",
            *(_row(one) for one in results),
            "",
            *_told(results),
        ]
    )


def write(path: Path, text: str) -> None:
    """Replace what stands behind the mark in a document."""
    head = path.read_text(encoding="utf-8").split(BEGIN)[0]
    path.write_text(f"{head}{BEGIN}\n\n{text.rstrip()}\n", encoding="utf-8")


def _row(one: Results) -> str:
    followed, executed, good = one.kinematic, one.simulated, one.usability
    return _line(
        one.robot,
        f"{followed.chunks:,}",
        f"{followed.refused.total():,}",
        f"{followed.rows:,}",
        _names(followed.breaches),
        f"{executed.rows:,}",
        _names(executed.stops),
        _names(executed.breaches),
        f"{good.succeeded} of {good.episodes}" if good.succeeded else "no task",
        _flawed(good),
    )


def _flawed(good: Usability) -> str:
    """How many chunks of the demonstrations, and what the gate did to those not released whole."""
    kinds = {"refused": good.refused, "truncated": good.truncated, "revoked": good.cut}
    done = [f"{found.total():,} {name}" for name, found in kinds.items() if found]
    stops = [f"stops: {_names(good.stops)}"] if good.stops else []
    return f"{', '.join([*done, *stops]) or '0'} of {good.chunks:,}"


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


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _names(counter: Counter[str]) -> str:
    return ", ".join(f"{count:,} {name}" for name, count in counter.most_common()) or "0"


def _plain(value: Any) -> Any:
    """JSON has no infinity, and its keys are words."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, float) and value == float("inf"):
        return None
    return value
