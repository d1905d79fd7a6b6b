"""What one robot sends and takes, from what was measured of few."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill

from bench.scale.fleet import SERVICES
from bench.scale.measured import PERIOD_NS, Found
from bench.scale.traffic import Sent

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


def fleet_text(messages: Mapping[str, Sent], every: Sequence[Found]) -> str:
    """In words: what one robot takes.

    Args:
        every: one way's, some with links that were counted. Of processor time a robot's is that
            with the fewest robots, which is the most.
    """
    few, most = (pick(every, key=lambda one: one.robots) for pick in (min, max))
    share = (most.memory_mb[1] - few.memory_mb[1]) / max(1, most.robots - few.robots)
    rate, size = _sums(messages)
    links = ""
    if few.links:
        size_of_packets, packets = few.links
        links = f", {packets:.0f} packets/s and {size_of_packets / 1e3:.0f} kB/s over links"
    return fill(
        f"{LINKS} links, {rate:.0f} messages/s, {size / 1e3:.0f} kB/s of messages{links}, "
        f"{(few.cpu_ms - few.router_ms) / PERIOD_MS:.3f} processors; of the router "
        f"{few.router_ms / PERIOD_MS:.3f} and {share:.1f} MB.",
        120,
    )


def _sums(messages: Mapping[str, Sent]) -> tuple[float, float]:
    every = messages.values()
    return sum(one.rate for one in every), sum(one.rate * one.size for one in every)
