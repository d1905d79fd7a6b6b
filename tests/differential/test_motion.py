"""What a robot did with the rows it was told: gate and reference stop at the same state."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Measured, Pacing, PartRows
from bench.equipment.core_gate import HELD, CoreGate
from fairlead.messages import Acted, Outcome
from fairlead.paths import gate_config, robot_dir
from tests.differential.gate_file import read_gate_file
from tests.differential.gates import ROBOTS, Pair
from tests.differential.motion_judge import Finding, MotionJudge, check_efforts, told
from tests.differential.motion_walk import MotionMaker, narrowed
from tests.differential.reference import open_tick

pytestmark = pytest.mark.processes

SEED = 4041
RUNS = 150
LONG_RUNS = 20_000
TOO_NEAR = 1e-7
PACINGS: tuple[Pacing, ...] = ("lockstep", "realtime")
MODES_LEFT_OUT = (2, 12)


@pytest.fixture(scope="module", params=ROBOTS)
def near_pair(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Pair]:
    """Each robot, under limits that it comes near."""
    robot, folder = request.param, tmp_path_factory.mktemp("gate")
    path = narrowed(gate_config(robot, "sim"), folder)
    core = CoreGate(path)
    yield Pair(robot, path, read_gate_file(path, robot_dir(robot) / f"{robot}.urdf"), core)
    core.close()


class Walk:
    """One armed run: a chunk for one part, and what is measured while it acts."""

    def __init__(self, pair: Pair, seed: int) -> None:
        self.pair, self.pacing = pair, PACINGS[seed % 2]
        self.rng = np.random.default_rng(seed)
        data = json.loads(pair.config.read_text())
        self.limits = {joint["name"]: joint for joint in data["joints"]}
        period_s = data["period_ns"] * 1e-9
        self.maker = MotionMaker(pair.file, self.rng, period_s)
        choices = [
            (index, mode)
            for index, part in enumerate(pair.file.parts)
            for mode in part.modes
            if mode not in MODES_LEFT_OUT
        ]
        self.part, self.mode = choices[int(self.rng.integers(len(choices)))]
        part = pair.file.parts[self.part]
        self.judge = MotionJudge(pair.file, self.limits, period_s, data["kinematics"]["root"], part)
        self.freezes_at = 1 if self.rng.random() < 0.3 else 64
        self.about = f"seed {seed}, {self.pacing}, {part.name} mode {self.mode}"

    def disagreement(self, codes: Counter[int]) -> str:
        """In words the first state on which the two judges differ."""
        core, last = self.pair.core, self.maker.start()
        core.start(self.pacing, last)
        core.claim(Case(self.pair.robot, self.pacing, last, Chunk(last.tick, 1, ())))
        last = self._still(last)
        core.state_reply(last)
        rows = self.maker.rows(self.part, self.mode, last)
        start = open_tick(self.pacing, last.tick)
        answer = core.send(Chunk(start, len(rows.values), (rows,)), last.tick)
        if answer.safe is None or answer.verdict.outcome == Outcome.REFUSED:
            codes[-1] += 1
            return ""
        if self.pacing == "realtime":
            last = self._still(last)
            core.state_reply(last)
        return self._act(rows, answer.verdict.verdict_id, answer.safe.horizon, last, codes)

    def _act(
        self, rows: PartRows, verdict_id: int, count: int, last: Measured, codes: Counter[int]
    ) -> str:
        core = self.pair.core
        for row in range(count + 3):
            acts = row < count
            state = self._next(rows, row if acts else None, last)
            acted = [HELD] * len(self.pair.file.parts)
            if acts:
                acted[self.part] = Acted(hold=0, verdict_id=verdict_id, row=row)
            reply = core.state_reply(state, tuple(acted))
            expected = self._expected(rows, row if acts else None, last, state)
            if expected.nearness < TOO_NEAR:
                return ""
            found = stop_of(core) if reply.stopped else (0, "")
            if found[0] not in (0, 40, 41, 42):
                return ""  # another check's stop
            codes[expected.code] += 1
            if found != (expected.code, expected.axis):
                return f"{self.about}, row {row}: reference {expected}, gate {found}"
            if reply.stopped or reply.verdicts:  # or what is left was judged again
                return ""
            last = state
        return ""

    def _expected(
        self, rows: PartRows, row: int | None, last: Measured, state: Measured
    ) -> Finding:
        effort = check_efforts(self.pair.file, self.limits, state)
        if effort.code:
            return effort
        return self.judge.judge(None if row is None else told(rows, row), last, state)

    def _next(self, rows: PartRows, row: int | None, last: Measured) -> Measured:
        if row is None or self.rng.random() < 0.25 or row >= self.freezes_at:
            return self.maker.frozen(last)
        return self.maker.follow(self.pair.file.parts[self.part], rows, row, last)

    def _still(self, last: Measured) -> Measured:
        return Measured(last.tick + 1, last.positions, last.velocities, last.efforts)


def stop_of(core: CoreGate) -> tuple[int, str]:
    """Code and axis of the stop, as the gate's status says in words."""
    found = re.search(r"G0(\d\d) (?:(\S+) )?(\S[^: ]*):", core.status().cause)
    assert found is not None, core.status().cause
    return int(found[1]), found[3]


@pytest.mark.parametrize(
    "runs", [RUNS, pytest.param(LONG_RUNS, marks=[pytest.mark.soak, pytest.mark.timeout(3600)])]
)
def test_gate_and_reference_stop_for_the_same_motion(near_pair: Pair, runs: int) -> None:
    codes: Counter[int] = Counter()
    for seed in range(SEED, SEED + runs):
        found = Walk(near_pair, seed).disagreement(codes)
        assert not found, found
    assert codes[0] > 2 * runs, codes
    assert min(codes[code] for code in (40, 41, 42)) >= 3, codes
    assert codes[-1] < 0.3 * runs, codes
