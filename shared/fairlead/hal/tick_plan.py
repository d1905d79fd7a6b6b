"""What the core answers when asked for a tick: a plan to carry out, or wait."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from fairlead.hal.backend import PartCommand
from fairlead.messages import Acted


@dataclass(frozen=True)
class TickPlan:
    """One tick, decided: ``acted`` per part; ``commands`` by part index, the rest hold.

    lease_ns: when the newest lease had come, on the HAL's monotonic clock; 0: none had.
    """

    tick: int
    acted: tuple[Acted, ...]
    commands: Mapping[int, PartCommand]
    lease_ns: int


@dataclass(frozen=True)
class Wait:
    """Lockstep: the world stands. ``lease``: a decision is missing; ``standstill``: paused."""

    reason: Literal["lease", "standstill"]
