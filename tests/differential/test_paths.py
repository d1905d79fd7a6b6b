"""Where rows lead: the gate against a reference that looks at many configurations.

Each released row has to be clear by the reference, and each refusal has a reason that it sees, too;
within 1e-5 of a limit either is right, and between two rows within the 10 mm that the gate goes by.
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Pacing, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.messages import Verdict
from fairlead.paths import robot_dir
from tests.differential.gate_file import MODES
from tests.differential.path_cases import narrowed, rows_of, start_of
from tests.differential.path_reference import PathReference
from tests.differential.reference import open_tick
from tests.differential.row_ends import RowMargins, poses_along

pytestmark = pytest.mark.processes

UNREACHABLE = 30
TICK, EXACT, BETWEEN = 100, 1e-5, 0.011
GRANT_NS = 75_000_000
PATH_CODES = (24, 26, 30, 31, 32, 33, 34)
SETUPS = [
    ("panda", "arm", "joint_position"),
    ("panda", "arm", "joint_velocity"),
    ("panda_mobile", "arm", "cartesian_delta"),
    ("panda_mobile", "base", "body_twist"),
    ("panda_mobile", "base", "joint_velocity"),
    ("dual_panda", "left_arm", "cartesian_twist"),
    ("dual_panda", "left_arm", "cartesian_pose"),
    ("dual_panda", "right_arm", "joint_position"),
]


def short_runs() -> list[tuple[str, str, str, int]]:
    """Fewer of dual_panda: the reference takes ten times as long for its 330 pairs of capsules."""
    return [(*setup, 8 if setup[0] == "dual_panda" else 25) for setup in SETUPS]


IN_MAKE_TEST = {
    ("panda", "arm", "joint_position"),
    ("panda_mobile", "arm", "cartesian_delta"),
    ("panda_mobile", "base", "body_twist"),
    ("dual_panda", "right_arm", "joint_position"),
}


def quick_runs() -> list[Any]:
    """What CI runs, `make test` some of them."""
    return [
        pytest.param(*run, marks=[] if run[:3] in IN_MAKE_TEST else pytest.mark.thorough)
        for run in short_runs()
    ]


def long_runs() -> list[Any]:
    """Sixty times as many starts as in CI."""
    marks = [pytest.mark.soak, pytest.mark.timeout(3600)]
    return [pytest.param(*setup, 60 * count, marks=marks) for *setup, count in short_runs()]


def certified_rows(data: dict[str, Any], pacing: Pacing) -> int:
    """How many rows can act before the gate judges anew (realtime: one more)."""
    return 1 if pacing == "lockstep" else max(2, -(-GRANT_NS // data["period_ns"])) + 1


def agree(verdict: Verdict, told: list[list[RowMargins]], released: int) -> None:
    """Asserts that rows before the first at fault are clear, and that one is not."""
    for row, branches in enumerate(told[:released]):
        for margins in branches:
            assert min(margins.at_ends.values()) >= -EXACT, (row, margins, verdict)
            assert min(margins.anywhere.values()) >= -BETWEEN, (row, margins, verdict)
    if verdict.code != 0:
        reasons = [margins.anywhere[verdict.code] for margins in told[released]]
        exact = verdict.code in (24, 26, 30, 33)
        assert min(reasons) <= (EXACT if exact else BETWEEN), verdict


@pytest.mark.parametrize(("robot", "part", "mode", "count"), [*quick_runs(), *long_runs()])
def test_released_rows_are_clear_and_refused_ones_are_not(
    robot: str, part: str, mode: str, count: int, tmp_path: Path
) -> None:
    data = narrowed(robot)
    config = tmp_path / "gate.json"
    config.write_text(json.dumps(data))
    reference = PathReference(data, robot_dir(robot) / f"{robot}.urdf")
    rng = np.random.default_rng(17)
    index = [one["name"] for one in data["parts"]].index(part)
    own = data["parts"][index]["joints"]
    active = tuple(reference.names.index(name) for name in own) if "joint" in mode else ()
    frame = "" if active else "base_link"
    codes: Counter[int] = Counter()
    core = CoreGate(config)
    try:
        for number in range(count):
            pacing: Pacing = "realtime" if number % 2 else "lockstep"
            start = start_of(data, reference, rng, part, mode)
            values = rows_of(data, rng, start, part, mode)
            if mode == "cartesian_pose":
                values = poses_along(reference.tool(start, part), values)
            rows = PartRows(index, MODES.index(mode), values, frame, active)
            chunk = Chunk(open_tick(pacing, TICK), len(values), (rows,))
            verdict = core.answers(Case(robot, pacing, still(TICK, start), chunk))[0].verdict
            codes[verdict.code] += 1
            if verdict.code != 0 and verdict.code not in PATH_CODES:
                continue
            if verdict.axis.startswith("tool ") and verdict.code == UNREACHABLE:
                continue  # the reference does not say when a tool gets nowhere
            released = len(values) if verdict.code == 0 else verdict.row
            certified = certified_rows(data, pacing)
            told = list(reference.rows(start, part, mode, values, certified))
            agree(verdict, told, released)
    finally:
        core.close()
    judged = sum(codes[code] for code in (0, *PATH_CODES))
    assert judged > count // 3, codes
    assert any(codes[code] for code in PATH_CODES), codes
