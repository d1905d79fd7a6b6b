"""A skill that sees: recorded with its pictures, trained from them, blind without, deployed."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError
from fairlead.messages import ResetEpisodeReply
from fairlead.paths import deployment_path
from fairlead.policy import Actions, Done, Failed, Observation, Policy
from fairlead.skill.manifest import SkillManifest, load_skill, read_skill
from fairlead_skill_runner.policies.onnx import OnnxPolicy
from fairlead_tools.learn.dataset import add, begin, episodes
from fairlead_tools.learn.record import Teacher, record
from fairlead_tools.learn.train_sight import SightRecipe, train_sight
from fairlead_tools.parity import local_episode
from fairlead_tools.parity.local_episode import LocalEpisode
from tests.cli.command import fairlead, fairlead_here
from tests.learn.drawn import drawn_pictures, drawn_sight

NAME = "ur5e_robosuite_cameras"
DEPLOYMENT = load_deployment(deployment_path(NAME))
CLONE, EXPERT = load_skill("bc-reach-cube"), load_skill("oracle-reach-cube")
SEED = 200
RESET = ResetEpisodeReply(tick=2, episode_tick=1, held_ticks=1)
renders = pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine")


def test_a_dataset_with_pictures_gives_back_what_was_written(tmp_path: Path) -> None:
    (found,) = episodes(drawn_pictures(tmp_path / "d", 3))
    np.testing.assert_array_equal(found.pictures["eye"], drawn_sight(3).pictures["eye"])
    np.testing.assert_array_equal(found.labels, drawn_sight(3).labels)


@pytest.mark.parametrize(("option", "value"), [("--beside", "0"), ("--expert", EXPERT.id)])
def test_what_only_datasets_of_states_can_use_is_refused(
    tmp_path: Path, option: str, value: str
) -> None:
    data = drawn_pictures(tmp_path / "d", 3)
    words = ["train", str(data), "--out", str(tmp_path / "mine"), option, value]
    done = fairlead_here(*words, state=tmp_path / "registry")
    assert done.returncode == 1
    assert f"train: {option}: expected it only for datasets without pictures" in done.stderr
    assert not (tmp_path / "mine").exists()


def test_pictures_that_nobody_labelled_train_nothing(tmp_path: Path) -> None:
    data = drawn_pictures(tmp_path / "d", 3, expert="")
    with pytest.raises(ConfigError, match="expected labels of an expert, got none: dataset record"):
        train_sight([data], SightRecipe(), tmp_path / "mine", print)


def test_a_skill_that_is_not_the_recorded_one_any_more_is_not_shipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "skills" / "own-eyes"
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(home.parent))
    home.mkdir(parents=True)
    document = CLONE.model_dump(mode="json", exclude_defaults=True) | {"id": "own-eyes"}
    (home / "rskill.yaml").write_text(yaml.safe_dump(document))
    data = tmp_path / "d"
    header = begin(data, read_skill(home), "ur5e", 0.0, EXPERT.id)
    add(data, header, drawn_sight(3))
    document["state_contract"]["bindings"] |= {"world_frame": "map"}
    (home / "rskill.yaml").write_text(yaml.safe_dump(document))
    with pytest.raises(ConfigError) as caught:
        train_sight([data], SightRecipe(), tmp_path / "mine", print)
    assert str(caught.value).splitlines() == [
        f"dataset {data}: its numbers mean others than those of skill own-eyes:",
        "  state_contract.bindings.world_frame: expected nothing, got base_link",
    ]


def test_the_onnx_file_says_what_jax_says_and_the_recipe_gives_it_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reference is jax's own forward pass, with the weights that it trained."""
    pytest.importorskip("jax", reason="no jax: pip install 'fairlead[train-pictures]'")
    pytest.importorskip("optax", reason="no optax")
    from fairlead_tools.learn import train_sight as module
    from fairlead_tools.learn.sight import Weights, fit_pictures, forward

    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    trained: list[Weights] = []

    def fit(*given: Any) -> Weights:
        trained.append(fit_pictures(*given))
        return trained[-1]

    monkeypatch.setattr(module, "fit_pictures", fit)
    data = drawn_pictures(tmp_path / "d", 3, 4)
    for name in ("one", "two"):
        train_sight([data], SightRecipe(5, 3), tmp_path / name, lambda text: None)
    first, again = ((tmp_path / name / "policy.onnx").read_bytes() for name in ("one", "two"))
    assert first == again
    skill = read_skill(tmp_path / "one")
    policy = OnnxPolicy.from_options(skill, skill.policy.options)
    told = json.loads((tmp_path / "one" / "stats.json").read_text())
    state, action = (told[key] for key in ("observation.state", "action"))
    episode = drawn_sight(9)
    planes = episode.pictures["eye"][:8].transpose(0, 3, 1, 2)
    pictures = planes.astype(np.float32) / np.float32(255)
    inputs = (episode.states[:8] - state["mean"]) / (np.array(state["std"]) + 1e-8)
    wanted = np.asarray(forward(trained[0], pictures, inputs.astype(np.float32)))
    for index, rows in enumerate(wanted.reshape(8, 4, 7)):
        seen = Observation(1, episode.states[index], "", {"eye": pictures[index]})
        restored = rows * np.array(action["std"]) + action["mean"]
        np.testing.assert_allclose(policy.infer(seen), restored, rtol=1e-4, atol=1e-5)


@renders
@pytest.mark.simulator
@pytest.mark.processes
@pytest.mark.thorough
def test_a_recording_sees_and_does_what_a_policy_in_one_process_does_bit_for_bit() -> None:
    [one] = record(DEPLOYMENT, CLONE, [SEED], 0.0, 8, lambda seed, tick: None, Teacher(EXPERT, 0.0))
    with closing(LocalEpisode(DEPLOYMENT, CLONE, SEED, RESET)) as local:
        assert local.act() and local.act()
        trace = local.trace
    assert [state.tobytes() for state in one.states[::4]] == trace.observations
    assert [row.tobytes() for row in one.acted] == trace.packed[1:]
    eye = one.pictures["eye"].astype(int)
    assert eye.shape == (8, 64, 64, 3) and one.labels.shape == (8, 4, 7)
    red = (eye[..., 0] > 100) & (eye[..., 1] < 90)
    assert (red.sum((1, 2)) > 10).all(), "the cube is in sight"
    assert (eye[0] != eye[-1]).any()


def seeing(contrast_min: float) -> SkillManifest:
    eye = CLONE.images["eye"].model_copy(update={"contrast_min": contrast_min})
    return CLONE.model_copy(update={"images": {"eye": eye}})


@pytest.mark.thorough
@renders
@pytest.mark.simulator
@pytest.mark.processes
def test_a_recording_ends_at_the_first_frame_that_does_not_count_and_says_so() -> None:
    """Deployed, the goal waits there: an older picture is none of this tick."""
    teacher = Teacher(EXPERT, 1.0)
    [one] = record(DEPLOYMENT, CLONE, [SEED], 0.0, 8, lambda seed, tick: None, teacher)
    contrasts = one.pictures["eye"].std(axis=(1, 2)).max(axis=1)
    limit = float(contrasts[4] + contrasts[3]) / 2
    assert (contrasts[:4] > limit).all() and contrasts[4] < limit
    lacking = "image eye from camera robot0_eye_in_hand: 1 pictures of one colour came since"
    for contrast_min, tick in ((limit, 5), (127.5, 1)):
        with pytest.raises(ConfigError) as caught:
            next(record(DEPLOYMENT, seeing(contrast_min), [SEED], 0.0, 8, lambda *_: None, teacher))
        assert str(caught.value) == (
            f"skill bc-reach-cube: tick {tick}: nothing to go by: {lacking} (contrast_min)"
        )
    seen = "tick 2: nothing to go by: image eye from camera"
    with (
        closing(LocalEpisode(DEPLOYMENT, seeing(127.5), SEED, RESET)) as local,
        pytest.raises(ConfigError, match=seen),
    ):
        local.act()


class _Blind:
    """The policy, for which every picture is black."""

    def __init__(self, policy: Policy) -> None:
        self._policy, self._black = policy, np.zeros((3, 64, 64), np.float32)

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        return self._policy.infer(replace(observation, images={"eye": self._black}))

    def reset(self) -> None:
        self._policy.reset()


@renders
@pytest.mark.thorough
@pytest.mark.simulator
@pytest.mark.processes
@pytest.mark.timeout(300)
def test_with_its_eye_shut_it_does_not_get_there(monkeypatch: pytest.MonkeyPatch) -> None:
    made = local_episode.make_policy
    monkeypatch.setattr(local_episode, "make_policy", lambda who, skill: _Blind(made(who, skill)))
    with closing(LocalEpisode(DEPLOYMENT, CLONE, SEED, RESET)) as local:
        while len(local.trace.packed) < 120 and not local.succeeded:
            local.act()
        assert not local.succeeded


@renders
@pytest.mark.thorough
@pytest.mark.simulator
@pytest.mark.processes
@pytest.mark.timeout(300)
def test_deployed_it_reaches_the_cube_and_no_bit_differs(tmp_path: Path) -> None:
    done = fairlead(
        "parity", "--json", "--skill", CLONE.id, "-d", NAME, "--seed", str(SEED),
        "--out", str(tmp_path / "out"), state=tmp_path / "registry",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads(done.stdout)
    (episode,) = report["episodes"]
    assert (report["same"], episode["succeeded"], episode["held"]) == (True, True, 0)
    assert [row["quantity"] for row in report["policy"]] == ["observations", "pictures", "actions"]
