"""One case: a robot's state, what acted before, what a claim may do, and one chunk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from fairlead.messages import FloatArray, LimitOverride

Pacing = Literal["lockstep", "realtime"]


@dataclass(frozen=True)
class PartRows:
    """Commands for one part. values: float64 ``[rows, width]``, SI as the mode says."""

    part: int
    mode: int
    values: FloatArray
    frame: str = ""
    active: tuple[int, ...] = ()


@dataclass(frozen=True)
class Chunk:
    """Row k is for tick ``start_tick + k``. horizon: as declared, which may be a lie."""

    start_tick: int
    horizon: int
    parts: tuple[PartRows, ...]


@dataclass(frozen=True)
class Measured:
    """State of one tick; arrays over commanded then passive joints [rad or m, per s, N m or N]."""

    tick: int
    positions: FloatArray
    velocities: FloatArray
    efforts: FloatArray
    came_from: FloatArray | None = None
    """Positions in the tick before; None: the session's first state."""


@dataclass(frozen=True)
class ActedRow:
    """The row that one part executed in the tick before a chunk's first live row."""

    mode: int
    frame: str
    active: tuple[int, ...]
    values: FloatArray
    is_measured: bool = True
    """Whether the newest state was measured after it (lockstep) or before (realtime)."""


Before = Mapping[int, ActedRow]
"""By index of the part; a part that is not there held."""


@dataclass(frozen=True)
class Case:
    """What the gate is shown, in order: ``first`` and, where there is one, ``earlier``.

    earlier: a chunk judged against ``first``, of which the HAL executes row 0 in every part it
    addresses, or holds (realtime: it is about to execute row 0). Then comes ``measured``, one tick
    later, and ``chunk``.
    Without ``earlier`` there is only ``measured`` (``first`` is None).
    """

    robot: str
    pacing: Pacing
    measured: Measured
    chunk: Chunk
    overrides: tuple[LimitOverride, ...] = ()
    horizon_max: int = 64
    first: Measured | None = None
    earlier: Chunk | None = None
    held: bool = False
    about: str = field(default="", compare=False)


def still(tick: int, positions: FloatArray) -> Measured:
    """A state of that tick that stands still and pushes nothing."""
    none = np.zeros(len(positions))
    return Measured(tick=tick, positions=positions, velocities=none, efforts=none)
