"""Cases by the thousand: ordinary ones, ones at every limit, and nonsense."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.equipment.case import Case, Chunk, Measured, Pacing, PartRows
from fairlead.messages import LimitOverride
from tests.differential.claims import drawn_override, tightenable, tightened
from tests.differential.gate_file import GateFile
from tests.differential.limit_rows import LimitMover
from tests.differential.nonsense import spoil
from tests.differential.reference import open_tick
from tests.differential.rows import RowMaker
from tests.differential.states import StateMaker

ROW_COUNTS = (1, 1, 2, 3, 4, 8)
TICKS = (2, 3, 2**53 + 1, 2**63, 2**64 - 9, 2**64 - 3)


class CaseMaker:
    """Draws cases for one robot; the same seed draws the same cases."""

    def __init__(self, robot: str, file: GateFile, seed: int) -> None:
        self._robot = robot
        self._file = file
        self._rng = np.random.default_rng(seed)
        self._states = StateMaker(file, self._rng)

    def draw(self) -> Case:
        """One case; in a third of them an earlier chunk acts before the judged one."""
        rng = self._rng
        pacing: Pacing = "lockstep" if rng.random() < 0.7 else "realtime"
        tick = TICKS[int(rng.integers(len(TICKS)))] if rng.random() < 0.1 else 100
        first = self._states.draw(tick)
        overrides = self._overrides() if rng.random() < 0.3 else ()
        case = Case(
            robot=self._robot,
            pacing=pacing,
            measured=first,
            chunk=Chunk(tick, 1, ()),
            overrides=overrides,
            horizon_max=int(rng.choice([64, 64, 8, 4])),
        )
        if rng.random() < 0.35:
            case = self._with_earlier(case, first)
        return self._with_chunk(case)

    def _with_earlier(self, case: Case, first: Measured) -> Case:
        start = open_tick(case.pacing, first.tick)
        earlier = self._drawn_chunk(case, first, {}, start, calm=True)
        return replace(
            case,
            first=first,
            earlier=earlier,
            held=case.pacing == "lockstep" and bool(self._rng.random() < 0.2),
            measured=self._states.next(first),
            horizon_max=64,
        )

    def _with_chunk(self, case: Case) -> Case:
        start = case.measured.tick - int(self._rng.choice([0, 0, 0, 1, 2]))
        start += int(case.pacing == "realtime")
        start = max(0, start)
        modes = {rows.part: rows for rows in case.earlier.parts} if case.earlier else {}
        chunk = self._drawn_chunk(case, case.measured, modes, start, calm=False)
        about = ""
        if self._rng.random() < 0.2:
            chunk, about = spoil(self._file, chunk, case.measured.tick, self._rng)
        return replace(case, chunk=chunk, about=about)

    def _drawn_chunk(
        self,
        case: Case,
        measured: Measured,
        earlier: dict[int, PartRows],
        start: int,
        calm: bool,
    ) -> Chunk:
        """Rows for some of the parts; where the part acted before, mostly on from there."""
        rng = self._rng
        file = tightened(self._file, case.overrides)
        maker, mover = RowMaker(file, rng), LimitMover(file, rng)
        count = int(rng.choice(ROW_COUNTS))
        order = rng.permutation(len(self._file.parts))
        parts = []
        for index in order[: int(rng.integers(1, len(order) + 1))].tolist():
            last = earlier.get(index) if rng.random() < 0.8 else None
            mode = last.mode if last and rng.random() < 0.8 else self._mode(index)
            rows = maker.draw(index, mode, count, measured, last)
            is_moved = rng.random() < (0.1 if calm else 0.5)
            parts.append(mover.moved(rows, measured) if is_moved else rows)
        return Chunk(start, count, tuple(parts))

    def _mode(self, part: int) -> int:
        return int(self._rng.choice(sorted(self._file.parts[part].modes)))

    def _overrides(self) -> tuple[LimitOverride, ...]:
        """One to three tighter limits."""
        found: list[LimitOverride] = []
        for _ in range(int(self._rng.integers(1, 4))):
            part = int(self._rng.integers(len(self._file.parts)))
            mode = self._mode(part)
            file = tightened(self._file, found)
            if tightenable(file, part, mode):
                found.append(drawn_override(file, part, mode, self._rng))
        return tuple(found)
