"""The policies that need no simulator, the trace they come from, and their options."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import JsonValue

from fairlead.errors import ConfigError, PolicyError
from fairlead.policy import Done, Observation
from fairlead_skill_runner.policies.constant import ConstantPolicy
from fairlead_skill_runner.policies.replay import ReplayPolicy
from fairlead_skill_runner.trace import TraceRecord, TraceWriter, read_trace
from tests.runner.scripted_robot import SKILL, story

SEEN = Observation(tick=1, state=np.zeros(30), prompt="")


def record(path: Path, *horizons: int, dim: int = 12) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    chunks = [rng.normal(size=(h, dim)).astype(np.float32) for h in horizons]
    writer = TraceWriter(path)
    for tick, chunk in enumerate(chunks, start=1):
        writer.write(TraceRecord(tick=tick, state=rng.normal(size=30), actions=chunk))
    writer.close()
    return chunks


def test_constant_repeats_its_row_for_the_skills_horizon() -> None:
    policy = ConstantPolicy.from_options(SKILL, {"row": [0.1] * 12})
    actions = policy.infer(SEEN)
    assert isinstance(actions, np.ndarray) and actions.dtype == np.float32
    np.testing.assert_array_equal(actions, np.full((8, 12), 0.1, dtype=np.float32))
    actions[:] = 9
    np.testing.assert_array_equal(policy.infer(SEEN), np.full((8, 12), 0.1, dtype=np.float32))


def test_constant_goes_through_its_phases_and_is_done() -> None:
    phases: list[JsonValue] = [
        {"row": [value] * 12, "ticks": ticks} for value, ticks in ((0.5, 3), (-0.5, 4))
    ]
    policy = ConstantPolicy.from_options(SKILL, {"phases": phases})
    for _ in range(2):
        for tick, expected in ((11, [0.5] * 3 + [-0.5] * 5), (13, [0.5] + [-0.5] * 7)):
            actions = policy.infer(Observation(tick, np.zeros(30), ""))
            assert isinstance(actions, np.ndarray)
            assert actions[:, 0].tolist() == expected
        assert isinstance(policy.infer(Observation(17, np.zeros(30), "")), np.ndarray)
        assert policy.infer(Observation(18, np.zeros(30), "")) == Done("every phase is over")
        policy.reset()


def test_phases_are_counted_in_ticks_from_the_first_answer_on_whatever_a_row_lasts() -> None:
    """A skill at half the control rate, asked as its runner asks."""
    phases: list[JsonValue] = [
        {"row": [value] * 12, "ticks": ticks} for value, ticks in ((0.5, 6), (-0.5, 8))
    ]
    policy = ConstantPolicy.from_options(SKILL, {"phases": phases})
    run = story(lockstep=False, periods=2)
    run.tick(11)
    actions = policy.infer(run.asked[-1].observation)
    assert isinstance(actions, np.ndarray)
    assert actions[:, 0].tolist() == [0.5] * 3 + [-0.5] * 5


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "constant policy: expected row or phases, got neither"),
        ({"row": [0.0] * 12, "phases": [{"row": [0.0] * 12, "ticks": 1}]},
         "constant policy: expected row or phases, got both"),
        ({"phases": [{"row": [0.0] * 3, "ticks": 1}]},
         "constant policy: expected a row of 12, got 3"),
        ({"row": [0.0] * 12, "horizon": 0},
         "constant policy: 1 problem(s):\n  horizon: Input should be greater than or equal to 1, "
         "got 0"),
        ({"row": [0.0] * 3}, "constant policy: expected a row of 12, got 3"),
        ({"row": [0.0] * 12, "speed": 1},
         "constant policy: 1 problem(s):\n  speed: unknown key (valid: row, phases, horizon)"),
    ],
)  # fmt: skip
def test_constant_options_that_do_not_fit_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        ConstantPolicy.from_options(SKILL, options)
    assert str(caught.value) == text


def test_a_trace_comes_back_bit_for_bit(tmp_path: Path) -> None:
    chunks = record(tmp_path / "t.jsonl", 8, 1)
    back = list(read_trace(tmp_path / "t.jsonl"))
    assert [r.tick for r in back] == [1, 2]
    assert [r.actions.tobytes() for r in back] == [c.tobytes() for c in chunks]
    assert back[0].state.dtype == np.float64
    assert back[0].state.shape == (30,)


def test_replay_gives_the_recorded_chunks_then_says_that_it_has_ended(tmp_path: Path) -> None:
    chunks = record(tmp_path / "t.jsonl", 8, 3)
    policy = ReplayPolicy.from_options(SKILL, {"trace": str(tmp_path / "t.jsonl")})
    np.testing.assert_array_equal(policy.infer(SEEN), chunks[0])
    np.testing.assert_array_equal(policy.infer(SEEN), chunks[1])
    with pytest.raises(PolicyError) as caught:
        policy.infer(SEEN)
    assert str(caught.value) == "replay policy: the recording ends after 2 chunks"
    policy.reset()
    np.testing.assert_array_equal(policy.infer(SEEN), chunks[0])


def test_a_recording_that_does_not_fit_names_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"

    def refusal() -> str:
        with pytest.raises(ConfigError) as caught:
            ReplayPolicy.from_options(SKILL, {"trace": str(path)})
        return str(caught.value)

    assert refusal() == f"{path}: cannot be read: No such file or directory"
    path.write_text("")
    assert refusal() == f"replay policy: {path}: expected recorded chunks, got none"
    record(path, 8, dim=7)
    assert refusal() == f"replay policy: {path} line 1: expected width 12, got 7"
    path.write_bytes(b"\xff\n")
    assert refusal().startswith(f"{path} line 1: not a trace record: ")
    record(path, 8)
    path.write_text(path.read_text() + '{"tick": 1}\n')
    assert refusal() == (
        f"{path} line 2: not a trace record: Object missing required field `state`"
    )
    record(path, 8)
    path.write_text(path.read_text().replace('"horizon":8', '"horizon":9'))
    assert refusal() == (
        f"{path} line 1: not a trace record: cannot reshape array of size 96 into shape (9,12)"
    )
