"""Plain cases of the robot `panda`, to be read and computed by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.equipment.case import Case, Chunk, Measured, PartRows, still
from fairlead.messages import FloatArray

TICK = 100
ARM, GRIPPER = 0, 1
POSITION, VELOCITY, OPENING = 0, 1, 10
JOINTS = tuple(range(7))
REST = (0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0, 0.04, 0.02, -0.02)
"""rad and m, inside all bounds."""


def rest(**joints: float) -> FloatArray:
    """The resting positions; ``j1=...`` to ``j7=...`` [rad] and ``opening`` [m] change some."""
    positions = np.array(REST)
    for name, value in joints.items():
        positions[7 if name == "opening" else int(name[1]) - 1] = value
    return positions


def arm(*rows: FloatArray, mode: int = POSITION) -> PartRows:
    """Rows for all seven joints, given as whole states; the gripper's column is 0."""
    values = np.array(rows)[:, :8].copy()
    values[:, 7] = 0.0
    return PartRows(ARM, mode, values, active=JOINTS)


def speeds(*rows: Sequence[float]) -> PartRows:
    """Velocity rows [rad/s] for the first joints, the others standing still."""
    values = np.zeros((len(rows), 8))
    for row, given in zip(values, rows, strict=True):
        row[: len(given)] = given
    return PartRows(ARM, VELOCITY, values, active=JOINTS)


def gripper(*openings: float) -> PartRows:
    """Openings [m]."""
    return PartRows(GRIPPER, OPENING, np.array([[opening] for opening in openings]))


def case(*parts: PartRows, measured: Measured | None = None, start: int = TICK) -> Case:
    """A lockstep case in which nothing acted before; at rest unless measured says otherwise."""
    chunk = Chunk(start, len(parts[0].values), parts)
    return Case("panda", "lockstep", measured or still(TICK, rest()), chunk)


def moving(*velocities: float) -> Measured:
    """At the resting positions, the first joints moving [rad/s]."""
    speed = np.zeros(len(REST))
    speed[: len(velocities)] = velocities
    return Measured(TICK, rest(), speed, np.zeros(len(REST)))
