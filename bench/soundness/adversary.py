"""Chunks that want a breach: within every limit of a row, and aimed beyond those of the path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.soundness.chunk_rows import Row
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.rows import FullScaleRows

KINDS = ("random", "corner", "creep", "turns")
ROWS_MOST = 16
SLOW = (0.05, 0.4)
NOISE = 0.3


class Adversary:
    """One robot's attacker.

    Args:
        recorded: rows of good demonstrations, which `spoiled` adds noise to.
        parts: which it may attack; None: all.
    """

    def __init__(
        self,
        robot: RobotManifest,
        recorded: Sequence[Row],
        rng: np.random.Generator,
        parts: Sequence[str] | None = None,
    ) -> None:
        self._robot, self._recorded, self._rng = robot, recorded, rng
        self._names = list(parts or robot.part_names)

    def begin(self, kind: str) -> None:
        """A new attack, on one to all parts, each in one of its modes.

        ``random`` directions at any scale, one ``corner`` of full scale, ``creep`` towards one,
        ``turns``: one direction at any scale, each row there or back.
        """
        self._kind, self._rows = kind, self._parts()
        self._wishes = {part: self._wish(one.axes) for part, one in self._rows.items()}

    def chunk(self, now: Moment) -> list[Row]:
        """Its next rows, up to sixteen, from where the robot is ``now``."""
        count = int(self._rng.integers(1, ROWS_MOST + 1))
        found: list[Row] = []
        for _ in range(count):
            if self._kind == "random":
                self._wishes = {part: self._wish(one.axes) for part, one in self._rows.items()}
            elif self._kind == "turns":
                way = -1.0 if self._rng.random() < 0.5 else 1.0
                self._wishes = {part: way * wish for part, wish in self._wishes.items()}
            found.append(
                {part: one.row(self._wishes[part], now) for part, one in self._rows.items()}
            )
        return found

    def go_on_after(self, row: Row | None) -> None:
        """The last row that will act, None: everything holds."""
        for part, one in self._rows.items():
            one.go_on_after(None if row is None else row[part].values)

    def _parts(self) -> dict[str, FullScaleRows]:
        count = int(self._rng.integers(1, len(self._names) + 1))
        found = {}
        for name in self._rng.choice(self._names, size=count, replace=False):
            modes = [*self._robot.part(name).control_modes]
            mode = modes[int(self._rng.integers(len(modes)))]
            found[str(name)] = FullScaleRows(self._robot, str(name), mode, turns_back=False)
        return found

    def _wish(self, axes: int) -> FloatArray:
        corner = np.where(self._rng.random(axes) < 0.5, -1.0, 1.0)
        if self._kind == "corner":
            return corner
        if self._kind == "creep":
            return np.asarray(self._rng.uniform(*SLOW) * corner)
        return self._rng.uniform(-1.0, 1.0, axes)

    def spoiled(self) -> tuple[int, list[Row]]:
        """Recorded rows with noise, and where in the record they begin."""
        count = int(self._rng.integers(1, ROWS_MOST + 1))
        start = int(self._rng.integers(max(1, len(self._recorded) - count)))
        found: list[Row] = []
        for row in self._recorded[start : start + count]:
            spoiled = {}
            for part, command in row.items():
                values = command.values.copy()
                if command.mode in _NOISY:
                    at = list(command.active) or slice(None)
                    values[at] *= 1.0 + NOISE * self._rng.uniform(-1.0, 1.0, values[at].shape)
                spoiled[part] = type(command)(
                    command.mode, command.frame_id, values, command.active
                )
            found.append(spoiled)
        return start, found


_NOISY = (
    ControlMode.JOINT_VELOCITY,
    ControlMode.CARTESIAN_DELTA,
    ControlMode.CARTESIAN_TWIST,
    ControlMode.BODY_TWIST,
)
