"""One episode of an attack on the gate: what each claim asks for, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from bench.equipment.core_gate import SOURCE
from bench.soundness.chunk_rows import Row
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.rows import FullScaleRows

ARM_JOINTS = 6
ROWS_MOST = 16


class Attack(Protocol):
    """ticks: how long it lasts. claims: the parts of each claim, by source."""

    ticks: int
    claims: dict[str, tuple[str, ...]]

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """The next rows of one claim, from the one for ``tick`` on."""

    def answered(self, source: str, row: Row | None) -> None:
        """The last row that will act of what was asked for; None: all was refused."""


class Parts:
    """The rows of some parts, each in one of its modes, within every limit of a row.

    Attributes:
        arms: those of them that are arms.
    """

    def __init__(self, robot: RobotManifest, modes: Mapping[str, ControlMode]) -> None:
        self._rows = {
            part: FullScaleRows(robot, part, mode, turns_back=False) for part, mode in modes.items()
        }
        self.arms = [part for part in modes if len(robot.part(part).joints) >= ARM_JOINTS]

    def axes(self, part: str) -> int:
        """How many numbers between -1 and 1 a wish for this part has."""
        return self._rows[part].axes

    def row(self, wishes: Mapping[str, FloatArray], now: Moment) -> Row:
        """One row of the parts that have a wish, shape ``[axes]`` in [-1, 1]."""
        return {part: self._rows[part].row(wish, now) for part, wish in wishes.items()}

    def go_on_after(self, row: Row | None) -> None:
        """The last row that will act; None, or a part that is not in it: it holds."""
        for part, one in self._rows.items():
            one.go_on_after(None if row is None or part not in row else row[part].values)


def some_mode(
    robot: RobotManifest, part: str, rng: np.random.Generator, but: Sequence[ControlMode] = ()
) -> ControlMode:
    """One of a part's modes."""
    modes = [m for m in robot.part(part).control_modes if m not in but]
    return modes[int(rng.integers(len(modes)))]


def everything(robot: RobotManifest) -> dict[str, tuple[str, ...]]:
    """One claim for the whole robot."""
    return {SOURCE: robot.part_names}
