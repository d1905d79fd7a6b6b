"""Stalls, and steps from one chunk to the next, of a run whose numbers are known."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from fairlead.messages import ActionChunk, Hold, JointState, Outcome, Verdict
from fairlead.modes import ControlMode
from fairlead_tools.record.run_log import Header, Run
from fairlead_tools.record.smoothness import smoothness
from tests.record.runs import (
    BASE,
    GRIPPER,
    NO_ROW,
    ROBOT,
    ROW,
    candidate,
    joints,
    part,
    verdict,
)


def chunk(seq: int, start_tick: int, speeds: list[float], opening: float = 0.0) -> ActionChunk:
    rows = np.zeros((len(speeds), ROBOT.n_dof))
    rows[:, 0] = speeds
    parts = (
        part(BASE, ControlMode.JOINT_VELOCITY, rows, (0,)),
        part(GRIPPER, ControlMode.GRIPPER_POSITION, [[opening]] * len(speeds), ()),
    )
    return msgspec.structs.replace(
        candidate(start_tick=start_tick), seq=seq, horizon=len(speeds), parts=parts
    )


def released(seq: int, first: int, last: int) -> tuple[int, Verdict]:
    said = verdict(seq, Outcome.RELEASED)
    return first, msgspec.structs.replace(said, released_first=first, released_last=last)


def states(first: int, last: int, without_row: range = range(0)) -> list[JointState]:
    """The state of tick n + 1 says what was done in tick n."""
    return [
        joints(tick + 1, ((NO_ROW if tick in without_row else ROW),) * len(ROBOT.parts))
        for tick in range(first - 1, last + 1)
    ]


def run(chunks: list[ActionChunk], joints: list[JointState]) -> Run:
    verdicts = [released(one.seq, one.start_tick, one.start_tick + one.horizon - 1)
                for one in chunks]  # fmt: skip
    return Run(Header(ROBOT.id, "sim", ""), joints=joints, chunks=chunks, verdicts=verdicts)


def test_the_seam_is_the_largest_step_between_chunks_of_the_range_asked() -> None:
    # Within the chunks it goes by 0.2; from the second to the third by 0.3, of 0.0 to 0.6.
    three = [chunk(1, 10, [0.0, 0.2]), chunk(2, 12, [0.3, 0.1], 0.08), chunk(3, 14, [0.4, 0.6])]
    found = smoothness(run(three, states(10, 15)), ROBOT)
    assert found.seam_step == pytest.approx(0.5)
    assert found.stalls == 0


def test_a_newer_chunk_takes_over_in_the_middle_of_an_older_one() -> None:
    found = smoothness(
        run([chunk(1, 10, [0.0] * 4), chunk(2, 12, [0.1] * 4)], states(10, 15)), ROBOT
    )
    assert found.seam_step == pytest.approx(1.0)  # the only step there is


def test_ticks_without_a_row_are_stalls_and_no_seam() -> None:
    apart = [chunk(1, 10, [0.0, 0.2]), chunk(2, 15, [0.4, 0.4]), chunk(3, 20, [0.1])]
    found = smoothness(run(apart, states(10, 20, range(12, 15))), ROBOT)
    assert found.stalls == 1
    assert found.seam_step is None
    twice = states(10, 20, range(12, 15))
    twice[8] = joints(18, (NO_ROW,) * len(ROBOT.parts))
    assert Hold(twice[8].acted[0].hold) is Hold.NO_ROW
    assert smoothness(run(apart, twice), ROBOT).stalls == 2


def test_one_chunk_has_no_seam() -> None:
    alone = run([chunk(1, 10, [0.0, 0.2])], states(10, 12))
    assert smoothness(alone, ROBOT).seam_step is None
    assert smoothness(Run(Header(ROBOT.id, "sim", "")), ROBOT).stalls == 0
