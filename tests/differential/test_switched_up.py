"""Rows with the composite switch up, of each of which another share happens, against a reference.

After rows of which little happened the next is faster than either end of the gain says. A joint's
bound stands where it then stops beyond it, but behind neither end: the gate may not release that.
"""

from __future__ import annotations

import itertools
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.messages import FloatArray
from fairlead.paths import gate_config, robot_dir
from tests.differential.gate_file import MODES
from tests.differential.path_cases import FAR, gain_of, with_wall
from tests.differential.path_reference import PathReference
from tests.differential.reference import open_tick

pytestmark = pytest.mark.processes

ROBOT, PART, MODE, TICK, WALKS = "panda_mobile", "arm", "cartesian_delta", 100, 120
FOLDED = np.array([0.0, 0.2, 0.0, -2.0, 0.0, 2.2, 0.785])
ROOM = 0.08, 3.0
"""What the gate may refuse too much: of a joint [rad], and of what unequal shares add."""
SHORT = {False: 0.1, True: 0.5}
"""Of what they add, what it has to refuse: it counts that to first order, of rows alike exactly."""


@pytest.mark.parametrize("other_ways", [False, True])
@pytest.mark.parametrize("count", [2, 3])
def test_a_bound_that_only_unequal_shares_stop_beyond(
    count: int, other_ways: bool, tmp_path: Path
) -> None:
    data, rng = open_space(), np.random.default_rng(count)
    reference = PathReference(data, robot_dir(ROBOT) / f"{ROBOT}.urdf")
    own = [reference.names.index(name) for name in part_of(data)["joints"]]
    low, high = gain_of(data, PART, MODE)
    found: Counter[tuple[str, int]] = Counter()
    for _ in range(WALKS):
        start = np.zeros(len([*data["joints"], *data["passive_joints"]]))
        start[own] = FOLDED + 0.3 * rng.normal(size=len(own))
        rows = np.array([fast_row(data, reference, rng, start, len(own))] * count)
        if other_ways:  # what is left of a turn is about another axis than the next
            rows[1:] = 0.5 * rows[1:] + 0.5 * fast_row(data, reference, rng, start, len(own))

        def rest(gains: tuple[float, ...], start: FloatArray = start, rows: FloatArray = rows
        ) -> FloatArray:  # fmt: skip
            return reference.reached(start, PART, MODE, rows, gains, switched_up=True)[1][own]

        equal = np.array([rest((gain,) * count) for gain in np.linspace(low, high, 5)])
        reached = np.array([rest(gains) for gains in itertools.product((low, high), repeat=count)])
        beyond = np.concatenate([reached.max(0) - equal.max(0), equal.min(0) - reached.min(0)])
        widest = int(beyond.argmax())
        if beyond[widest] < 0.003:
            continue
        joint, side = own[widest % len(own)], "lower" if widest >= len(own) else "upper"
        outwards = 1.0 if side == "upper" else -1.0
        end = reached[:, widest % len(own)]
        limit = float(end.max() if side == "upper" else end.min())
        for name, at in (
            ("short of", -SHORT[other_ways] * beyond[widest]),
            ("beyond", ROOM[0] + ROOM[1] * beyond[widest]),
        ):
            bounded = with_bound(data, joint, side, limit + outwards * at)
            found[name, verdict_of(bounded, start, rows, tmp_path)] += 1
    assert found["short of", 0] == 0, found
    enough = WALKS // (20 if other_ways else 10)
    assert found["short of", 24] > enough, found
    assert found["beyond", 0] > enough, found
    assert found["beyond", 24] == 0, found


def open_space() -> dict[str, Any]:
    return with_wall(json.loads(gate_config(ROBOT, "sim").read_text()), FAR, PART)


def part_of(data: dict[str, Any]) -> dict[str, Any]:
    return next(one for one in data["parts"] if one["name"] == PART)


def fast_row(
    data: dict[str, Any],
    reference: PathReference,
    rng: np.random.Generator,
    start: FloatArray,
    count: int,
) -> FloatArray:
    """Mostly of one joint, at most as fast as one row may be."""
    turn = 0.15 * rng.normal(size=count)
    turn[int(rng.integers(4))] += rng.choice([-1.0, 1.0])
    row = np.asarray(reference.jacobian(start, PART) @ turn)
    block = part_of(data)["modes"][MODE]
    most = min(
        float(block[f"{kind}_limit"] / np.linalg.norm(half))
        for kind, half in (("linear", row[:3]), ("angular", row[3:]))
    )
    return rng.uniform(0.3, 0.98) * most * row


def with_bound(data: dict[str, Any], joint: int, side: str, at: float) -> dict[str, Any]:
    joints = [dict(one) for one in data["joints"]]
    joints[joint]["bounds"] = joints[joint]["bounds"] | {side: at}
    return data | {"joints": joints}


def verdict_of(data: dict[str, Any], start: FloatArray, values: FloatArray, folder: Path) -> int:
    """Its code, of the rows in realtime, where all of them are certified."""
    config = folder / "gate.json"
    config.write_text(json.dumps(data))
    switch = [one["name"] for one in data["parts"]].index("composite")
    parts = (
        PartRows(0, MODES.index(MODE), values, "base_link", ()),
        PartRows(switch, MODES.index("composite_mode"), np.ones((len(values), 1)), "", ()),
    )
    chunk = Chunk(open_tick("realtime", TICK), len(values), parts)
    core = CoreGate(config)
    try:
        return core.answers(Case(ROBOT, "realtime", still(TICK, start), chunk))[0].verdict.code
    finally:
        core.close()
