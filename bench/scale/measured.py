"""What was found of a number of robots on one router, or in one dataflow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from bench.scale.processes import Spending

PERIOD_NS = 20_000_000


@dataclass(frozen=True)
class Tick:
    """One tick of a robot, by CLOCK_MONOTONIC [ns].

    lease_ns: when the gate's newest answer to a state had come.
    moves: whether a row acted.
    """

    stamp_ns: int
    lease_ns: int
    moves: bool


@dataclass(frozen=True)
class Window:
    """What was seen of all robots in one window of time.

    links: bytes and packets a second of a robot's links with the router; None: not counted.
    """

    spent: Spending
    ticks: Sequence[Sequence[Tick]]
    links: tuple[float, float] | None = None

    @property
    def cpu_ms(self) -> float:
        """Processor time a tick of a robot, with its share of the router."""
        return self._a_tick("robots") + self.router_ms

    @property
    def router_ms(self) -> float:
        """That share."""
        return self._a_tick("router")

    @property
    def memory_mb(self) -> tuple[float, float]:
        """A robot's own processes', and that of the whole router."""
        robots, router = (self.spent.groups[name].memory_mb for name in ("robots", "router"))
        return robots / len(self.ticks), router

    def _a_tick(self, group: str) -> float:
        return self.spent.groups[group].running_ms / max(1, sum(map(len, self.ticks)))


@dataclass(frozen=True)
class Found:
    """Of one way and number of robots, over all rounds; processor time: the median round's.

    cpu_ms, router_ms, memory_mb: as of a `Window`.
    error_ms: p50 and p99 of how far ticks came from their period.
    lease_ms: p50 and p99 from a state to the gate's answer at the HAL.
    lost, held: shares of the ticks that should have been: none came; nothing moved in it.
    busy: share of the machine, whoever took it.
    """

    way: str
    robots: int
    cpu_ms: float
    router_ms: float
    memory_mb: tuple[float, float]
    error_ms: tuple[float, float]
    lease_ms: tuple[float, float]
    lost: float
    held: float
    busy: float
    links: tuple[float, float] | None


def found(way: str, windows: Sequence[Window]) -> Found:
    """All rounds together."""
    robots = len(windows[0].ticks)
    each = [ticks for window in windows for ticks in window.ticks]
    expected = sum(window.spent.seconds for window in windows) * robots * 1e9 / PERIOD_NS
    came = sum(len(ticks) for ticks in each)
    middle = sorted(windows, key=lambda window: window.cpu_ms)[len(windows) // 2]
    return Found(
        way,
        robots,
        middle.cpu_ms,
        middle.router_ms,
        middle.memory_mb,
        _quantiles(_errors_ms(each)),
        _quantiles(_leases_ms(each)),
        max(0.0, 1 - came / expected),
        sum(not tick.moves for ticks in each for tick in ticks) / max(1, came),
        middle.spent.busy,
        middle.links,
    )


def _errors_ms(each: Iterable[Sequence[Tick]]) -> list[float]:
    return [
        abs(after.stamp_ns - one.stamp_ns - PERIOD_NS) / 1e6
        for ticks in each
        for one, after in pairwise(ticks)
    ]


def _leases_ms(each: Iterable[Sequence[Tick]]) -> list[float]:
    """An answer that came only after the next tick counts as one that took that long."""
    return [
        (after.lease_ns if after.lease_ns > one.stamp_ns else after.stamp_ns) / 1e6
        - one.stamp_ns / 1e6
        for ticks in each
        for one, after in pairwise(ticks)
    ]


def _quantiles(values: Sequence[float]) -> tuple[float, float]:
    if not values:
        return math.nan, math.nan
    ordered = sorted(values)
    p50, p99 = (ordered[math.ceil(q * len(ordered)) - 1] for q in (0.5, 0.99))
    return p50, p99
