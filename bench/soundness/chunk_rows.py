"""Rows as part commands, and the chunk that carries them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bench.equipment.case import Chunk, PartRows
from fairlead.hal.backend import PartCommand
from fairlead.robot.manifest import RobotManifest

Row = Mapping[str, PartCommand]


def chunk_of(robot: RobotManifest, tick: int, rows: Sequence[Row]) -> Chunk:
    """One chunk from the row for ``tick`` on; all rows command the same parts in the same modes."""
    parts = []
    for name, first in rows[0].items():
        values = np.stack([row[name].values for row in rows])
        index = robot.part_names.index(name)
        parts.append(PartRows(index, int(first.mode), values, first.frame_id, first.active))
    return Chunk(tick, len(rows), tuple(sorted(parts, key=lambda part: part.part)))
