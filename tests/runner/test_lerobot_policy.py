"""Policies of LeRobot's in an interpreter of their own: what is refused, and what ends a goal."""

from __future__ import annotations

import json
import os
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError, PolicyError
from fairlead.plugins import POLICIES
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.backends import check_policy_options
from fairlead_skill_runner.policies.onnx_files import action_names
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_tools.learn.lerobot_export import export_lerobot
from tests.client.turns import until
from tests.learn.drawn import CLONE, drawn_pictures
from tests.runner.lerobot_skill import (
    DIM,
    HORIZON,
    NAME,
    STATE,
    checkpoint,
    install,
    made,
    other_python,
    refusal,
    seen,
)

pytestmark = pytest.mark.processes


@pytest.fixture(autouse=True)
def skills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "skills"
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(folder))
    checkpoint(folder / NAME / "own")
    return folder


@pytest.fixture
def python(tmp_path: Path) -> Path:
    return other_python(tmp_path)


@pytest.mark.parametrize("deltas", [(0,), (-1, 0)])
def test_the_first_rows_of_lerobot_s_chunk_are_the_answer(
    skills: Path, python: Path, deltas: tuple[int, ...], capfd: pytest.CaptureFixture[str]
) -> None:
    indices = None if deltas == (0,) else list(deltas)
    checkpoint(skills / NAME / "own", observation_delta_indices=indices)
    with made(install(skills, python, deltas, seed=9)) as policy:
        said = capfd.readouterr()
        policy.reset()
        for count in (1, 2):
            rows = policy.infer(seen(len(deltas)))
            assert rows.shape == (HORIZON, DIM) and rows.dtype == np.float32
            wanted = np.array([0.25, 0.2, count, 2, 9, 1, 0], np.float32)
            np.testing.assert_array_equal(rows[5], wanted)
        policy.reset()
        assert policy.infer(seen(len(deltas)))[0, 2] == 1
    assert (
        "act by lerobot 0.6.1 on cpu: chunks of 12 rows, of which the first 8 are used" in said.err
    )
    assert said.out == "", "what lerobot prints is for the log"


def test_an_interpreter_that_is_none_or_has_no_lerobot_is_named_with_the_way_out(
    skills: Path, tmp_path: Path
) -> None:
    assert refusal(install(skills, tmp_path / "absent")) == (
        f"lerobot policy: python: expected an interpreter that has lerobot, got {tmp_path}/absent: "
        "No such file or directory"
    )
    assert re.fullmatch(
        r"lerobot policy: loading: /bin/true ended with status 0; it said why above",
        refusal(install(skills, Path("/bin/true"))),
    )
    way_out = f"{sys.executable} -m pip install 'lerobot>=0.6'"
    for path, got in ((Path(sys.executable), "none"), (other_python(tmp_path, "0.5.9"), "0.5.9")):
        assert refusal(install(skills, path)) == (
            "lerobot policy: loading failed: RuntimeError: expected lerobot 0.6 or newer in "
            f"{sys.executable}, got {got}: {way_out}"
        )


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"inputs": {"observation.state": [9]}},
         "observation.state: the checkpoint has [9], expected [8] of the skill\n"
         "  observation.images.eye: the checkpoint has none, expected [3, 64, 64] of the skill"),
        ({"inputs": {"observation.state": [8], "observation.eye": [3, 96, 64]}},
         "observation.eye: the checkpoint has [3, 96, 64], expected [3, 64, 64] of the skill"),
        ({"inputs": {"observation.state": [8], "eye": [3, 64, 64], "observation.tactile": [2]}},
         "observation.tactile: the checkpoint has [2], expected none in the skill"),
        ({"outputs": {"action": [6]}}, "action: the checkpoint has [6], expected [7] of the skill"),
        ({"observation_delta_indices": [-1, 0]},
         "state_contract.deltas: expected [-1, 0], the checkpoint's, got [0]"),
        ({"observation_delta_indices": [-1, 0]},
         "images.eye.deltas: expected [-1, 0], the checkpoint's, got [0]"),
        ({"stats": {}}, "observation.state: was normalised in training, but the processors have"),
        ({"rows": 7},
         "rows of a chunk: expected at least the skill's execute_steps, 8, got 7"),
    ],
)  # fmt: skip
def test_a_checkpoint_that_does_not_fit_is_refused_when_it_is_loaded(
    skills: Path, python: Path, changes: dict[str, Any], text: str
) -> None:
    checkpoint(skills / NAME / "own", **changes)
    assert text in refusal(install(skills, python))


def test_names_order_and_rate_of_the_dataset_that_trained_it_are_compared(
    skills: Path, python: Path, tmp_path: Path
) -> None:
    """The dataset is what `export lerobot` writes for the skill it was recorded with."""
    data = drawn_pictures(tmp_path / "data", 3)
    export_lerobot(data, tmp_path / "exported", CLONE, failed=False)
    skill, file = install(skills, python, dataset=str(tmp_path / "exported")), "meta/info.json"
    with made(skill):
        pass
    told = json.loads((tmp_path / "exported" / file).read_text())
    names = told["features"]["action"]["names"]
    names[0], names[1], told["fps"] = names[1], names[0], 30
    (tmp_path / "exported" / file).write_text(json.dumps(told))
    said = refusal(skill)
    assert "the names of action: expected cartesian_delta[0], cartesian_delta[1], " in said
    assert ", got cartesian_delta[1], cartesian_delta[0], " in said
    assert said.endswith("\n  rate_hz: expected 30, its fps, got 20")
    (tmp_path / "exported" / file).write_text('{"fps": 20}')
    assert "no LeRobotDataset: KeyError('features')" in refusal(skill)
    assert "cannot be read: No such file" in refusal(install(skills, python, dataset="absent"))


def test_an_order_of_actions_that_the_checkpoint_knows_is_the_skill_s(
    skills: Path, python: Path
) -> None:
    names = list(action_names(CLONE))
    for known, fits in ((names, True), (["x", "y"], True), (names[::-1], False)):
        checkpoint(skills / NAME / "own", action_feature_names=known)
        if fits:
            with made(install(skills, python)):
                pass
        else:
            said = refusal(install(skills, python))
            assert "the order of action: expected cartesian_delta[0], " in said
            assert ", got gripper_position[0], cartesian_delta[5], " in said


def test_files_that_are_missing_or_run_other_s_code_are_refused_before_anything_is_started(
    skills: Path,
) -> None:
    skill, own = install(skills, Path("/absent")), skills / NAME / "own"
    (own / "policy_preprocessor.json").unlink()
    assert "got no policy_preprocessor.json; one older than lerobot 0.4 gets" in refusal(skill)
    for steps, text in (
        ('{"steps": [{"class": "subprocess.Popen", "config": {"args": "sh"}}]}',
         "expected steps of lerobot's own, got 'subprocess.Popen'"),
        ('{"steps": [{}]}', "no processor of lerobot's: KeyError('class')"),
        ("[]", "no processor of lerobot's: TypeError"),
        ("{", "no processor of lerobot's: JSONDecodeError"),
        ("[" * 100_000, "no processor of lerobot's: RecursionError"),
    ):  # fmt: skip
        (own / "policy_preprocessor.json").write_text(steps)
        assert text in refusal(skill)
    (own / "model.safetensors").rename(own / "pytorch_model.bin")
    assert refusal(skill).endswith("got no model.safetensors")


def test_options_are_checked_without_any_file(skills: Path) -> None:
    with pytest.raises(ConfigError, match="chekpoint: unknown key, did you mean checkpoint"):
        check_policy_options(install(skills, Path("/absent"), chekpoint="own"))
    skill = load_skill("bc-reach-cube")
    contract = skill.state_contract.model_copy(update={"deltas": (-1, 0)})
    with pytest.raises(ConfigError) as caught:
        check_policy_options(skill.model_copy(update={"state_contract": contract}))
    assert str(caught.value) == (
        "skill bc-reach-cube: state_contract.deltas: expected [0] for the backend onnx, which sees "
        "no earlier states, got [-1, 0]"
    )


@pytest.mark.parametrize(
    ("does", "text"),
    [
        ("fail", "inference failed: KeyError: 'no such token'"),
        ("die", "ended with status -9; it said why above"),
        ("nonsense", "said no message: Expecting"),
    ],
)
def test_what_goes_wrong_over_there_is_a_typed_error(
    skills: Path, python: Path, does: str, text: str
) -> None:
    skill = install(skills, python)
    checkpoint(skills / NAME / "own", does=does)
    with pytest.raises(PolicyError) as caught, made(skill) as policy:
        policy.reset()
        policy.infer(seen())
        policy.infer(seen())
    assert text in str(caught.value)


@pytest.mark.parametrize("number", ["nan", "inf", "-inf"])
def test_a_number_that_is_none_is_a_typed_failure(skills: Path, python: Path, number: str) -> None:
    checkpoint(skills / NAME / "own", does="nan", number=float(number))
    with made(install(skills, python)) as policy:
        assert np.isfinite(policy.infer(seen())).all()
        late = replace(seen(), state=np.full(STATE, 2.0))
        with pytest.raises(PolicyError, match=f"finite .*got {number} in row 2 dimension 5"):
            policy.infer(late)


def test_a_checkpoint_that_was_trained_on_is_loaded_anew_for_the_next_goal(
    skills: Path, python: Path
) -> None:
    with made(install(skills, python)) as policy:
        assert len(policy.infer(seen())) == HORIZON
        checkpoint(skills / NAME / "own", outputs={"action": [6]})
        with pytest.raises(ConfigError, match=r"action: the checkpoint has \[6\]"):
            policy.reset()
        checkpoint(skills / NAME / "own", rows=9)
        policy.reset()
        assert len(policy.infer(seen())) == HORIZON


@pytest.mark.asyncio
async def test_one_that_hangs_is_ended_with_its_worker_and_the_next_goal_has_a_new_one(
    skills: Path, python: Path, tmp_path: Path
) -> None:
    checkpoint(skills / NAME / "own", does="hang")
    skill = install(skills, python).model_copy(update={"inference_timeout_s": 2.0})
    worker = PolicyWorker(POLICIES.find("lerobot"), skill, skill.policy.options)
    for _ in range(2):
        await worker.load()
        await worker.reset()
        await worker.infer(seen())
        assert worker.pid is not None
        [policy] = children(worker.pid)
        [below] = children(policy)
        with pytest.raises(PolicyError, match="inference took longer than 2 s"):
            await worker.infer(seen())
        await until(lambda below=below: not alive(below))  # type: ignore[misc]
    await worker.close()


def children(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(one) for one in text.split()]


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
