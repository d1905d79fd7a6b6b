"""Clips and thresholds that slots ask for: what is changed, what is kept, what is said of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairlead.messages import floats
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.fitted_rows import FitCounts, fitted
from fairlead_skill_runner.run_core import RunCore
from fairlead_skill_runner.trace import TraceRecord, TraceWriter, read_trace
from tests.runner.scripted_robot import ROUTES, Story, setup

MOBILE = load_robot("panda_mobile")
PI05 = load_skill("pi05-robocasa365-human300-nf4")
SHIPPED = ["gr00t-robocasa", "pi05-robocasa365-human300-nf4", "rldx-robocasa", "rldx1-ft-rc365-nf4"]
FITTING = resolve_routes(PI05.action_contract, MOBILE)

Rows = np.ndarray[Any, np.dtype[np.float32]]
NUMBERS = st.floats(width=32, allow_nan=True, allow_infinity=True)


def row(**numbers: float) -> Rows:
    """One of 12 numbers, 0.25 but for some: ``_6=1.02``."""
    made = np.full((1, 12), 0.25, np.float32)
    for name, number in numbers.items():
        made[0, int(name[1:])] = number
    return made


def training(raw: Rows) -> Rows:
    """As RoboCasa's gym wrapper and robosuite's controllers treat it, written down a second time.

    ``robocasa/wrappers/gym_wrapper.py`` ``unmap_action``: -1.0 if x < 0.5 else 1.0 for gripper and
    mode; ``robosuite/controllers/parts/controller.py`` ``scale_action``: np.clip to -1 and 1.
    """
    made = raw.copy()
    for column in (*range(6), 7, 8, 9):
        made[:, column] = [min(max(x, -1.0), 1.0) for x in raw[:, column]]
    for column in (6, 11):
        made[:, column] = [-1.0 if x < 0.5 else 1.0 for x in raw[:, column]]
    return made


@given(st.lists(st.floats(-3, 3, width=32), min_size=12, max_size=12))
def test_the_shipped_robocasa_skills_fit_as_the_training_environment_did(
    numbers: list[float],
) -> None:
    raw = np.array([numbers], np.float32)
    for name in SHIPPED:
        routes = resolve_routes(load_skill(name).action_contract, MOBILE)
        assert fitted(routes, raw).tobytes() == training(raw).tobytes()


@given(st.lists(NUMBERS, min_size=12, max_size=12))
def test_slots_that_ask_for_nothing_keep_every_bit(numbers: list[float]) -> None:
    raw = np.array([numbers], np.float32)
    assert fitted(ROUTES, raw) is raw
    arm_only = tuple(r for r in FITTING if r.part_name == "arm")
    made = fitted(arm_only, raw)
    assert made[:, 6:].tobytes() == raw[:, 6:].tobytes()


@given(st.lists(NUMBERS, min_size=12, max_size=12))
def test_no_clip_and_no_threshold_makes_a_command_of_what_is_not_finite(
    numbers: list[float],
) -> None:
    raw = np.array([numbers], np.float32)
    made = fitted(FITTING, raw)
    wrong = ~np.isfinite(raw)
    assert (~np.isfinite(made) == wrong).all()
    assert made[wrong].tobytes() == raw[wrong].tobytes()


@pytest.mark.parametrize(
    ("number", "made"), [(0.49999997, -1.0), (0.5, 1.0), (0.50000006, 1.0), (-7.0, -1.0)]
)
def test_a_threshold_decides_from_its_number_on(number: float, made: float) -> None:
    for column in (6, 11):
        assert fitted(FITTING, row(**{f"_{column}": number}))[0, column] == made


def test_what_was_changed_is_counted_slot_by_slot() -> None:
    counts = FitCounts(FITTING)
    assert counts.words() == ""
    inside = row(_6=1.0, _11=-1.0)
    counts.add(inside, fitted(FITTING, inside))
    assert counts.words() == ""
    for raw in (row(_6=0.9, _7=1.02, _11=-1.0), row(_6=-1.0, _8=-1.5, _9=1.25, _11=1.0)):
        counts.add(raw, fitted(FITTING, raw))
    assert counts.words() == (
        "slot [6, 6] gripper_position: 1 of 3 decided by threshold; "
        "slot [7, 9] joint_velocity: 3 of 9 clipped, farthest -1.5"
    )


def test_the_goal_sends_fitted_rows_remembers_the_policy_s_and_says_how_many_were_changed() -> None:
    run = Story(RunCore(replace(setup(lockstep=False), routes=FITTING), 0.0))
    run.tick(10)
    raw = np.repeat(row(_6=0.9, _7=1.02, _11=0.1), 8, axis=0)
    run.answer(raw)
    base = next(part for part in run.chunk.parts if part.part == 2)
    gripper = next(part for part in run.chunk.parts if part.part == 1)
    assert floats(base.values, 11).max() == 1.0
    assert (floats(gripper.values, 1) == 0.0).all()
    run.judge(first=11)
    for tick in range(11, 17):
        run.tick(tick)
    [past] = run.asked[1].observation.answers
    assert past.rows.tobytes() == raw.tobytes()
    run.take(run.core.cancel("test"))
    assert run.core.result is not None
    assert run.core.result.detail == (
        "cancelled by test; slot [6, 6] gripper_position: 8 of 8 decided by threshold; "
        "slot [7, 9] joint_velocity: 8 of 24 clipped, farthest 1.02; "
        "slot [11, 11] composite_mode: 8 of 8 decided by threshold"
    )


def test_the_trace_has_the_raw_numbers_and_those_that_were_sent(tmp_path: Path) -> None:
    raw = row(_6=0.9, _7=1.02)
    records = [
        TraceRecord(1, np.zeros(3), raw, fitted(FITTING, raw)),
        TraceRecord(2, np.zeros(3), raw),
    ]
    writer = TraceWriter(tmp_path / "trace.jsonl")
    for record in records:
        writer.write(record)
    writer.close()
    first, second = read_trace(tmp_path / "trace.jsonl")
    assert first.actions.tobytes() == second.actions.tobytes() == raw.tobytes()
    assert first.proposed.tobytes() == fitted(FITTING, raw).tobytes() != raw.tobytes()
    assert second.sent is None
    assert second.proposed.tobytes() == raw.tobytes()
