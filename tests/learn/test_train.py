"""Training: the same bytes for the same recipe, and a network that says what was trained."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest, load_skill, read_skill
from fairlead_skill_runner.policies.onnx import OnnxPolicy
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy
from fairlead_tools.learn.labels import label, state_beside
from fairlead_tools.learn.network import features, fit, onnx_bytes
from fairlead_tools.learn.train import Recipe, train
from tests.cli.command import fairlead_here
from tests.learn.drawn import EXPERT, drawn_dataset, drawn_episode, drawn_state
from tests.runner.onnx_skill import install

RECIPE = Recipe(seed=4, beside=2, epochs=3, widths=(16,))


def rotation(quaternion: np.ndarray) -> np.ndarray:
    yaw = 2 * np.arctan2(quaternion[2], quaternion[3])
    return np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])


def in_odom(state: np.ndarray, first: int) -> np.ndarray:
    return np.array(state[7:9] + rotation(state[10:14]) @ state[first : first + 2])


def test_beside_a_state_the_world_stands_and_what_is_held_goes_with_the_hand() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        state = drawn_state(rng)
        beside = state_beside(state, rng)
        np.testing.assert_allclose(in_odom(beside, 23), in_odom(state, 23), atol=1e-9)
        np.testing.assert_allclose(
            rotation(beside[10:14]) @ rotation(beside[26:30]),
            rotation(state[10:14]) @ rotation(state[26:30]), atol=1e-9,
        )  # fmt: skip
        held = state.copy()
        held[16:19] = held[0:3] + 0.01
        moved = state_beside(held, rng)
        np.testing.assert_allclose(moved[16:19] - moved[0:3], 0.01)
        if np.linalg.norm(state[16:19] - state[0:3]) > 0.1:
            np.testing.assert_allclose(in_odom(beside, 16), in_odom(state, 16), atol=1e-9)
            assert beside[18] == state[18]


def test_labels_are_the_expert_s_own_whatever_was_asked_beside() -> None:
    episode, alone = drawn_episode(2), OraclePolicy(8)
    labels = label(OraclePolicy(8), [episode], beside=3, seed=0)
    assert labels.states.shape == (12 + 6 * 3, 30)
    own = [
        row for state, row in zip(*labels, strict=True) if (state == episode.states).all(1).any()
    ]
    for tick, state in enumerate(episode.states, start=1):
        np.testing.assert_array_equal(own[tick - 1], alone.infer(Observation(tick, state, "")))


def test_the_onnx_file_says_what_scikit_learn_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reference is scikit-learn's own prediction from the features in float64."""
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    rng = np.random.default_rng(3)
    states = np.array([drawn_state(rng) for _ in range(60)])
    rows = rng.normal(size=(60, 48))
    seen = features(np.zeros(30), np.ones(30))
    net = fit(seen(states), rows, 0, (16, 8), 3)
    skill = install(tmp_path, onnx_bytes(seen, net, 4, 12))
    policy = OnnxPolicy.from_options(skill, skill.policy.options)
    for state, wanted in zip(states[:20], net.predict(seen(states[:20])), strict=True):
        got = policy.infer(Observation(1, state, ""))
        np.testing.assert_allclose(got.reshape(-1), wanted, rtol=1e-4, atol=1e-4)


def test_the_same_recipe_gives_the_same_bytes_and_another_seed_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    data = drawn_dataset(tmp_path / "data", drawn_episode(1), drawn_episode(2))
    files = []
    for name, recipe in (("one", RECIPE), ("two", RECIPE), ("three", Recipe(5, 2, 3, (16,)))):
        train([data], EXPERT, recipe, tmp_path / name, lambda text: None)
        skill = read_skill(tmp_path / name)
        OnnxPolicy.from_options(skill, skill.policy.options)
        files.append((tmp_path / name / "policy.onnx").read_bytes())
    assert files[0] == files[1] != files[2]
    told = json.loads((tmp_path / "one" / "training.json").read_text())
    assert told["datasets"][0]["seeds"] == [1, 2]
    assert told["labels"] == 2 * (12 + 6 * 2)
    slots = read_skill(tmp_path / "one").action_contract.slots
    assert [slot.clip for slot in slots] == [(-1, 1), None, (-1, 1), None, None]
    assert [slot.threshold for slot in slots] == [None, 0, None, None, 0]


def test_a_skill_that_is_there_is_not_overwritten(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "data", drawn_episode(1))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "rskill.yaml").write_text("id: mine")
    with pytest.raises(ConfigError, match="expected a folder without a skill"):
        train([data], EXPERT, RECIPE, tmp_path / "mine", lambda text: None)


def test_only_the_scripted_expert_s_own_backend_is_cloned(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "data", drawn_episode(1))
    clone = load_skill("bc-counter-to-cabinet")  # of the same layout
    with pytest.raises(ConfigError) as caught:
        train([data], clone, RECIPE, tmp_path / "mine", lambda text: None)
    assert str(caught.value) == (
        "train: bc-counter-to-cabinet: expected the backend oracle, got onnx"
    )
    assert not (tmp_path / "mine").exists()


def test_an_expert_that_sees_other_numbers_than_the_recorded_is_refused(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "data", drawn_episode(1))
    document = EXPERT.model_dump(mode="json")
    document["state_contract"]["bindings"]["world_frame"] = "map"
    with pytest.raises(ConfigError) as caught:
        train([data], SkillManifest.model_validate(document), RECIPE, tmp_path / "mine", print)
    assert str(caught.value).splitlines() == [
        f"dataset {data}: its numbers mean others than those of skill {EXPERT.id}:",
        "  state_contract.bindings.world_frame: expected nothing, got odom",
    ]
    assert not (tmp_path / "mine").exists()


@pytest.mark.parametrize("name", ["My Clone", "klön", "."])
def test_a_name_that_no_skill_can_have_is_said_before_anything_is_trained(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    data = drawn_dataset(tmp_path / "data", drawn_episode(1))
    said: list[str] = []
    with pytest.raises(ConfigError, match="^train: --out: the skill's id: expected 1 to 64 of a-z"):
        train([data], EXPERT, RECIPE, Path(name), said.append)
    assert said == []


def test_a_seed_that_scikit_learn_does_not_take_is_a_wrong_command_line(tmp_path: Path) -> None:
    done = fairlead_here("train", "d", "--out", "mine", "--seed", str(2**32), state=tmp_path)
    assert done.returncode == 2 and "--seed" in done.stderr


def test_too_few_labels_to_leave_one_out_are_said(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "data", drawn_episode(1, 2))
    with pytest.raises(ConfigError, match="^train: expected 20 labels or more, got 4$"):
        train([data], EXPERT, RECIPE, tmp_path / "mine", print)
    assert not (tmp_path / "mine").exists()
