"""Demonstrations without gate and services, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator

from bench.soundness.demonstrations import Demonstration, Rows
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick


def episode(driven: DrivenRobot, seed: int) -> Iterator[Tick]:
    """One demonstration on this robot."""
    now = driven.reset(seed)
    expert = Demonstration(driven, seed)
    rows: Rows = []
    for tick in range(1, expert.most_ticks + 1):
        rows = rows or expert.chunk(tick)
        if not rows:
            return
        done = driven.step("oracle", now, rows.pop(0))
        yield done
        now = done.after
        if expert.is_over():
            return
