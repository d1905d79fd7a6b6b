"""Statistics beside an ONNX file: what goes in normalised, and what comes out restored."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.policy import Observation
from tests.runner.onnx_skill import (
    DIM,
    HORIZON,
    SEEN,
    WEIGHTS,
    install,
    linear,
    made,
    refusal,
    statistics,
)


@pytest.fixture(autouse=True)
def skills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("form", ["mean_std", "min_max"])
def test_state_goes_in_normalised_and_actions_come_out_restored(skills: Path, form: str) -> None:
    stats = statistics(install(skills, linear(WEIGHTS)))
    skill = install(skills, linear(WEIGHTS), stats, form)
    state, action = (
        {key: np.array(stats[name][key]) for key in ("mean", "std", "min", "max")}
        for name in ("observation.state", "action")
    )
    # As LeRobot writes both; the network computes in float32.
    if form == "mean_std":
        given = (SEEN.state - state["mean"]) / state["std"]
        rows = (given @ WEIGHTS).reshape(HORIZON, DIM) * action["std"] + action["mean"]
    else:
        given = 2 * (SEEN.state - state["min"]) / (state["max"] - state["min"]) - 1
        rows = (given @ WEIGHTS).reshape(HORIZON, DIM)
        rows = (rows + 1) / 2 * (action["max"] - action["min"]) + action["min"]
    np.testing.assert_allclose(made(skill).infer(SEEN), rows, rtol=1e-4, atol=1e-4)


def test_a_dimension_that_never_moved_becomes_zero_and_its_mean(skills: Path) -> None:
    stats = statistics(install(skills, linear(WEIGHTS)))
    state, action = stats["observation.state"], stats["action"]
    state["std"][3] = action["std"][10] = 0.0
    skill = install(skills, linear(WEIGHTS), stats)
    seen = SEEN.state.copy()
    seen[3] = state["mean"][3]
    rows = made(skill).infer(Observation(1, seen, ""))
    assert (rows[:, 10] == np.float32(action["mean"][10])).all()
    assert np.isfinite(rows).all()


def test_by_its_range_a_dimension_that_never_moved_becomes_minus_one(skills: Path) -> None:
    """As in LeRobot: its denominator is 1e-8 then, and the least is -1."""
    stats = statistics(install(skills, linear(WEIGHTS)))
    state, action = stats["observation.state"], stats["action"]
    state["max"][3], action["max"][10] = state["min"][3], action["min"][10]
    skill = install(skills, linear(WEIGHTS), stats, "min_max")
    seen = SEEN.state.copy()
    seen[3] = state["min"][3]
    least, most = np.array(state["min"]), np.array(state["max"])
    given = 2 * (seen - least) / np.where(most == least, 1e-8, most - least) - 1
    assert given[3] == -1
    rows = (given @ WEIGHTS).reshape(HORIZON, DIM)
    least, most = np.array(action["min"]), np.array(action["max"])
    rows = (rows + 1) / 2 * np.where(most == least, 1e-8, most - least) + least
    found = made(skill).infer(Observation(1, seen, ""))
    np.testing.assert_allclose(found, rows, rtol=1e-4, atol=1e-4)


def test_quantiles_are_openpi_s_both_ways_also_of_a_dimension_that_never_moved(
    skills: Path,
) -> None:
    """As its `Normalize` and `Unnormalize` write it: 1e-6 is added to every range."""
    stats = statistics(install(skills, linear(WEIGHTS)))
    state, action = stats["observation.state"], stats["action"]
    state["q99"][3], action["q99"][10] = state["q01"][3], action["q01"][10]
    skill = install(skills, linear(WEIGHTS), stats, "quantiles")
    seen = SEEN.state.copy()
    seen[3] = state["q01"][3] + 3e-7
    q01, q99 = np.array(state["q01"]), np.array(state["q99"])
    given = (seen - q01) / (q99 - q01 + 1e-6) * 2.0 - 1.0
    np.testing.assert_allclose(given[3], -0.4)
    rows = (given @ WEIGHTS).reshape(HORIZON, DIM)
    q01, q99 = np.array(action["q01"]), np.array(action["q99"])
    rows = (rows + 1.0) / 2.0 * (q99 - q01 + 1e-6) + q01
    found = made(skill).infer(Observation(1, seen, ""))
    np.testing.assert_allclose(found, rows, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize(
    ("damage", "text"),
    [
        ("crossed", "expected q99 of cartesian_delta[4] at least q01, "),
        ("missing", "action.q01: expected 12 finite numbers, got none"),
        ("infinite", "action.q99: expected 12 finite numbers, got "),
    ],
)
def test_quantiles_that_are_none_are_refused(skills: Path, damage: str, text: str) -> None:
    stats = statistics(install(skills, linear(WEIGHTS)))
    action = stats["action"]
    if damage == "crossed":
        action["q99"][4] = action["q01"][4] - 0.1
    elif damage == "missing":
        del action["q01"]
    else:
        action["q99"][4] = float("inf")
    assert text in refusal(install(skills, linear(WEIGHTS), stats, "quantiles"))
