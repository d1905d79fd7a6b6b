"""Rows that turn aside, of each of which another share happens, against a reference of its own.

A wall stands where equal shares do not lead, but the lower end of the gain in one row and the upper
in another do: the gate may not release them. Further away than all that is in doubt, it has to.
"""

from __future__ import annotations

import itertools
import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.messages import FloatArray
from fairlead.paths import robot_dir
from tests.differential.gate_file import MODES
from tests.differential.path_cases import gain_of, narrowed, rows_of, start_of, with_wall
from tests.differential.path_reference import PathReference
from tests.differential.reference import open_tick

pytestmark = pytest.mark.processes

TICK, WALL, SURROUNDINGS = 100, 3.0, (31, 34)
ROWS, WALKS = 3, 45
REACH = 1.3
"""No joint turns anything that is further away [m]."""
EQUAL = np.linspace(0.0, 1.0, 21)


@pytest.mark.parametrize(
    ("robot", "part", "mode", "gentle"),
    [
        ("panda", "arm", "joint_velocity", 0.4),
        ("panda_mobile", "arm", "cartesian_delta", 0.15),
        ("panda_mobile", "base", "joint_velocity", 0.4),
    ],
)
def test_a_wall_that_only_unequal_shares_reach(
    robot: str, part: str, mode: str, gentle: float, tmp_path: Path
) -> None:
    data, rng = with_wall(narrowed(robot), WALL, part), np.random.default_rng(5)
    reference = PathReference(data, robot_dir(robot) / f"{robot}.urdf")
    low, high = gain_of(data, part, mode)
    corners = list(itertools.product((low, high), repeat=ROWS))
    found: Counter[tuple[str, int]] = Counter()
    for _ in range(WALKS):
        start = start_of(data, reference, rng, part, mode)
        rows = gentle * turning(rng, rows_of(data, rng, start, part, mode)[0])

        def left(
            shares: Iterable[Sequence[float]], start: FloatArray = start, rows: FloatArray = rows
        ) -> float:
            places = [reference.reached(start, part, mode, rows, gains) for gains in shares]
            return min(reference.margin(place, part, mode) for both in places for place in both)

        equal = left([low + share * (high - low)] * ROWS for share in EQUAL)
        reached = left(corners)
        if reached > equal - 2e-3:
            continue
        doubt = doubt_of(reference, start, part, mode, rows, (low, high))
        for name, room in (("short of", 0.9 * (equal - reached)), ("beyond", doubt)):
            walled = with_wall(data, WALL - equal + room, part)
            found[name, verdict_of(walled, robot, part, mode, start, rows, tmp_path)] += 1
    assert found["short of", 0] == 0
    assert sum(found["short of", code] for code in SURROUNDINGS) > WALKS // 8, found
    assert found["beyond", 0] > WALKS // 8, found
    assert not any(found["beyond", code] for code in SURROUNDINGS), found


def doubt_of(
    reference: PathReference,
    start: FloatArray,
    part: str,
    mode: str,
    rows: FloatArray,
    gain: tuple[float, float],
) -> float:
    """How far anything can get if what the ends of the gain make of each joint adds up [m]."""
    widths, doubt = np.zeros_like(start), 0.0
    for count in range(1, ROWS + 1):
        low, high = (
            reference.reached(start, part, mode, rows[:count], [end] * count)[-1] for end in gain
        )
        doubt += float(np.abs(high - low - widths).sum())
        widths = high - low
    return REACH * doubt


def turning(rng: np.random.Generator, row: FloatArray) -> FloatArray:
    """Rows of the same sizes, each axis to and fro as it happens."""
    return np.asarray(row * rng.choice([-1.0, 1.0], (ROWS, len(row))))


def verdict_of(
    data: dict[str, Any],
    robot: str,
    part: str,
    mode: str,
    start: FloatArray,
    values: FloatArray,
    folder: Path,
) -> int:
    """Its code, of the rows in realtime, where all of them are certified."""
    config = folder / "gate.json"
    config.write_text(json.dumps(data))
    index = [one["name"] for one in data["parts"]].index(part)
    names = [joint["name"] for joint in data["joints"]]
    own = next(one for one in data["parts"] if one["name"] == part)["joints"]
    active = tuple(names.index(name) for name in own) if "joint" in mode else ()
    rows = PartRows(index, MODES.index(mode), values, "" if active else "base_link", active)
    chunk = Chunk(open_tick("realtime", TICK), len(values), (rows,))
    core = CoreGate(config)
    try:
        return core.answers(Case(robot, "realtime", still(TICK, start), chunk))[0].verdict.code
    finally:
        core.close()
