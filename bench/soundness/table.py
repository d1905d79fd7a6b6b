"""The results as the tables of docs/soundness.md, and as one document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bench.soundness.results import Results

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
    """Three tables and what was told, as Markdown."""
    return "\n".join(
        [
            f"Measured on {day} by `{command}`.",
            "",
            "## Followed by a second model",
            "",
            "| robot | chunks | released whole | truncated | refused | cut off | rows that acted "
            "| places checked | not solved | breaches | smallest margins |",
            "|---|---|---|---|---|---|---|---|---|---|---|",
            *(_kinematic(one) for one in results),
            "",
            "## Executed in the simulator",
            "",
            "| robot | rows executed | chunks | truncated | refused | cut off | stops "
            "| ticks in breach | smallest margins |",
            "|---|---|---|---|---|---|---|---|---|",
            *(_simulated(one) for one in results),
            "",
            "## Good demonstrations",
            "",
            "| robot | episodes | succeeded | chunks | refused | truncated | cut off | stops |",
            "|---|---|---|---|---|---|---|---|",
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
        f"{found.released:,}",
        _codes(found.truncated),
        _codes(found.refused),
        _codes(found.cut),
        f"{found.rows:,}",
        f"{found.configurations:,}",
        f"{found.not_reached:,}",
        _names(found.breaches),
        _rooms(found.worst),
    )


def _simulated(one: Results) -> str:
    found = one.simulated
    return _line(
        one.robot,
        f"{found.rows:,}",
        f"{found.chunks:,}",
        _codes(found.truncated),
        _codes(found.refused),
        _codes(found.cut),
        _names(found.stops),
        _names(found.breaches),
        _rooms(found.worst),
    )


def _usability(one: Results) -> str:
    found = one.usability
    share = sum(found.refused.values()) / max(1, found.chunks)
    return _line(
        one.robot,
        f"{found.episodes}",
        f"{found.succeeded}" if found.succeeded else "no task",
        f"{found.chunks:,}",
        f"{_codes(found.refused)} ({share:.2%})",
        _codes(found.truncated),
        _codes(found.cut),
        _names(found.stops),
    )


def _told(results: Sequence[Results]) -> list[str]:
    """The first breach of each robot, without what its row was."""
    return [
        f"First breach of {one.robot}: {line.partition(', row')[0]}"
        for one in results
        for told in (one.kinematic.told, one.simulated.told, one.usability.told)
        for line in told[:1]
    ]


def _line(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _codes(counter: Counter[int]) -> str:
    """How many in all, and by which check most."""
    if not counter:
        return "0"
    [(code, _)] = counter.most_common(1)
    return f"{counter.total():,}, most G{code:03d}"


def _names(counter: Counter[str]) -> str:
    return ", ".join(f"{count:,} {name}" for name, count in counter.most_common()) or "0"


def _rooms(worst: dict[str, float]) -> str:
    known = {rule: room for rule, room in worst.items() if room < float("inf")}
    return ", ".join(f"{rule} {room:.4f}" for rule, room in known.items()) or "-"


def _plain(value: Any) -> Any:
    """JSON has no infinity, and its keys are words."""
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, float) and value == float("inf"):
        return None
    return value
