"""Arithmetic for many robots, from what was measured of few."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bench.scale.fleet import SERVICES
from bench.scale.measured import PERIOD_NS, Found
from bench.scale.traffic import Sent

SHARD, FLEET = 32, 1000
PERIOD_MS = PERIOD_NS / 1e6
LINKS = len(SERVICES) + 1
"""Of a robot with its router: HAL, gate, and the client that feeds it."""


def traffic_table(messages: Mapping[str, Sent]) -> str:
    """In Markdown: what a robot sends, and the sum."""
    lines = ["| one robot sends | messages/s | bytes each | bytes/s |", "|---|---|---|---|"]
    for key, one in messages.items():
        lines.append(f"| `{key}` | {one.rate:.1f} | {one.size} | {one.rate * one.size:.0f} |")
    rate, size = _sums(messages)
    return "\n".join([*lines, f"| all | {rate:.1f} | | {size:.0f} |"])


def fleet_table(messages: Mapping[str, Sent], every: Sequence[Found]) -> str:
    """In Markdown: of one robot, of a router's, of a thousand.

    Args:
        every: one way's, some with links that were counted. Of processor time a robot's is that
            with the fewest robots, which is the most.
    """
    few, most = (pick(every, key=lambda one: one.robots) for pick in (min, max))
    share = (most.memory_mb[1] - few.memory_mb[1]) / max(1, most.robots - few.robots)
    rows: list[tuple[str, float, int]] = [
        ("links", LINKS, 0),
        ("messages/s", _sums(messages)[0], 0),
        ("their kB/s", _sums(messages)[1] / 1e3, 0),
        ("HAL, gate and client: processors", (few.cpu_ms - few.router_ms) / PERIOD_MS, 3),
        ("router: processors", few.router_ms / PERIOD_MS, 3),
        ("router: MB more for each robot", share, 1),
    ]
    if few.links:
        rows[3:3] = [
            ("packets/s over links", few.links[1], 0),
            ("kB/s over links", few.links[0] / 1e3, 0),
        ]
    routers = -(-FLEET // SHARD)
    lines = [
        f"| | one robot | a router of {SHARD} | {FLEET:,} robots on {routers} routers |",
        "|---|---|---|---|",
    ]
    for what, one, digits in rows:
        few_digits = min(digits, 1)
        cells = (f"{one:.{digits}f}", f"{one * SHARD:,.{few_digits}f}", f"{one * FLEET:,.0f}")
        lines.append(f"| {what} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _sums(messages: Mapping[str, Sent]) -> tuple[float, float]:
    every = messages.values()
    return sum(one.rate for one in every), sum(one.rate * one.size for one in every)
