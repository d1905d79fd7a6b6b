"""Policies in ONNX files: the same bits in every process, and one clear error for what is wrong."""

from __future__ import annotations

import asyncio
import builtins
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from fairlead.errors import ConfigError
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.onnx import OnnxPolicy
from fairlead_skill_runner.policies.onnx_files import action_names
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_tools.skills.install import policy_problems
from tests.runner.onnx_skill import (
    DIM,
    HORIZON,
    SEEN,
    STATE,
    WEIGHTS,
    install,
    linear,
    made,
    model,
    refusal,
    statistics,
    values,
)

RNG = np.random.default_rng(2)


@pytest.fixture(autouse=True)
def skills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    return tmp_path


def test_weights_in_another_file_are_refused_though_they_are_there(
    skills: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = onnx.load_from_string(linear(WEIGHTS))
    for one in whole.graph.initializer:  # only raw ones go elsewhere
        one.CopyFrom(onnx.numpy_helper.from_array(onnx.numpy_helper.to_array(one), one.name))
    onnx.external_data_helper.convert_model_to_external_data(whole, location="w", size_threshold=0)
    onnx.save(whole, skills / "split.onnx")
    skill = install(skills, (skills / "split.onnx").read_bytes())
    (skills / skill.id / "w").write_bytes((skills / "w").read_bytes())
    monkeypatch.chdir(skills / skill.id)
    assert "or its weights are in another file: " in refusal(skill)


@pytest.mark.processes
def test_the_worker_says_bit_for_bit_what_the_policy_says_in_this_process(skills: Path) -> None:
    stats = statistics(install(skills, linear(WEIGHTS)))
    skill = install(skills, linear(WEIGHTS), stats)

    async def ask() -> list[bytes]:
        worker = PolicyWorker(POLICIES.find("onnx"), skill, skill.policy.options)
        try:
            await worker.load()
            await worker.reset()
            return [np.asarray(await worker.infer(SEEN)).tobytes() for _ in range(2)]
        finally:
            await worker.close()

    assert asyncio.run(ask()) == [made(skill).infer(SEEN).tobytes()] * 2


@pytest.mark.parametrize(
    ("axes", "dtype", "deltas"),
    [("chw", "float32_unit", [0]), ("hwc", "uint8", [0]), ("chw", "uint8", [-2, 0])],
)
def test_a_picture_goes_in_as_the_skill_declares_it_and_nothing_is_done_to_it(
    skills: Path, axes: str, dtype: str, deltas: list[int]
) -> None:
    """The network gives back 48 numbers of its input as they lie in it."""
    spec = {
        "camera": "robot0_eye_in_hand", "width": 4, "height": 6, "deltas": deltas,
        "axes": axes, "dtype": dtype,
    }  # fmt: skip
    size = (6, 4, 3) if axes == "hwc" else (3, 6, 4)
    kind = TensorProto.UINT8 if dtype == "uint8" else TensorProto.FLOAT
    drawn = RNG.integers(0, 256, (len(deltas), *size))
    frames = drawn.astype(np.uint8) if dtype == "uint8" else (drawn / 256).astype(np.float32)
    shape = [1, *(frames.shape if len(deltas) > 1 else frames.shape[1:])]
    data = model(
        [
            helper.make_node("Cast", ["eye"], ["numbers"], to=TensorProto.FLOAT),
            helper.make_node("Reshape", ["numbers", "flat"], ["line"]),
            helper.make_node("Slice", ["line", "zero", "count", "axis"], ["begin"]),
            helper.make_node("Reshape", ["begin", "shape"], ["rows"]),
            helper.make_node("ReduceSum", ["state"], ["sum"], keepdims=0),
            helper.make_node("Mul", ["sum", "nought"], ["none"]),
            helper.make_node("Add", ["rows", "none"], ["actions"]),
        ],
        [values("state", TensorProto.FLOAT, [1, STATE]), values("eye", kind, shape)],
        [values("actions", TensorProto.FLOAT, [1, HORIZON, DIM])],
        flat=np.array([1, -1], np.int64),
        zero=np.array([0], np.int64),
        count=np.array([HORIZON * DIM], np.int64),
        axis=np.array([1], np.int64),
        nought=np.zeros((), np.float32),
        shape=np.array([1, HORIZON, DIM], np.int64),
    )
    policy = made(install(skills, data, images={"wrist": {"input": "eye", "spec": spec}}))
    seen = Observation(
        1, SEEN.state, "", {"wrist": frames[-1]}, frames={"wrist": frames} if deltas[1:] else {}
    )
    wanted = frames.reshape(-1)[: HORIZON * DIM].astype(np.float32)
    np.testing.assert_array_equal(policy.infer(seen).reshape(-1), wanted)


def test_another_file_of_the_same_name_is_refused(skills: Path) -> None:
    skill = install(skills, linear(WEIGHTS))
    path = skills / skill.id / "policy.onnx"
    path.write_bytes(linear(WEIGHTS * 2))
    wanted = skill.policy.options["model"]["sha256"]  # type: ignore[index,call-overload]
    assert refusal(skill).startswith(f"onnx policy: {path}: expected SHA-256 {wanted}, got ")
    path.unlink()
    missing = f"onnx policy: {path}: cannot be read: No such file or directory"
    assert refusal(skill) == missing
    (said,) = policy_problems(skill, path.parent)
    assert said.endswith(f": policy.options: {missing}")


def test_statistics_are_compared_before_the_skill_is_loaded(skills: Path) -> None:
    right = statistics(install(skills, linear(WEIGHTS)))
    skill = install(skills, linear(WEIGHTS), right)
    assert policy_problems(skill, skills / skill.id) == []
    right["action"]["names"][0] = "another"
    skill = install(skills, linear(WEIGHTS), right)
    (said,) = policy_problems(skill, skills / skill.id)
    assert "stats.json: action.names: expected 12 names: " in said


@pytest.mark.parametrize(
    ("data", "options", "text"),
    [
        (b"text", {}, "policy.onnx: no ONNX model that can be run, or its weights are in another"),
        (linear(WEIGHTS[:16], state=16), {},
         "onnx policy: input state: expected float32 [1, 30], got float32 [1, 16]"),
        (linear(WEIGHTS.astype(np.float64), dtype=TensorProto.DOUBLE), {},
         "onnx policy: input state: expected float32 [1, 30], got tensor(double) [1, 30]"),
        (linear(WEIGHTS), {"state": "obs"},
         "onnx policy: inputs of the model: expected obs, got state"),
        (linear(WEIGHTS), {"actions": "rows"},
         "onnx policy: the model: expected an output rows, got none (valid: actions)"),
    ],
)  # fmt: skip
def test_a_model_that_does_not_fit_the_skill_is_refused_when_it_is_loaded(
    skills: Path, data: bytes, options: dict[str, Any], text: str
) -> None:
    assert text in refusal(install(skills, data, **options))


def test_more_rows_than_the_horizon_are_refused_when_the_model_is_loaded(skills: Path) -> None:
    skill = install(skills, linear(WEIGHTS))
    short = skill.model_copy(update={"horizon": HORIZON - 1, "execute_steps": 1})
    assert refusal(short) == (
        "onnx policy: output actions: expected float32 [1, 1 to 3, 12], got float32 [1, 4, 12]"
    )


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"action": None}, "action: expected a map of names and statistics, got NoneType"),
        ({"action": {"names": ["a"]}}, "action.names: expected 12 names: cartesian_delta[0], "),
        ("short", "observation.state.mean: expected 30 finite numbers, got "),
        ("nan", "action.std: expected 12 finite numbers, got "),
        ("negative", "action: expected std of cartesian_delta[4] at least 0, got -1"),
        ("list", "stats.json: expected a map, got list"),
        ("deep", "stats.json: not JSON: maximum recursion depth"),
    ],
)
def test_statistics_that_are_not_the_skill_s_are_refused(
    skills: Path, change: Any, text: str
) -> None:
    stats: Any = statistics(install(skills, linear(WEIGHTS)))
    if change == "short":
        stats["observation.state"]["mean"].pop()
    elif change == "nan":
        stats["action"]["std"][4] = float("inf")
    elif change == "negative":
        stats["action"]["std"][4] = -1.0
    elif change == "deep":
        stats = b"[" * 100_000
    else:
        stats = [] if change == "list" else stats | change
    assert text in refusal(install(skills, linear(WEIGHTS), stats))


def test_options_are_checked_without_any_file(skills: Path) -> None:
    skill = install(skills, linear(WEIGHTS))
    hashed = skill.policy.options["model"]
    cases: list[tuple[dict[str, Any], str]] = [
        ({"model": {"file": "../policy.onnx", "sha256": "0" * 64}}, "model.file: "),
        ({"model": hashed, "images": {"eye": "eye"}},
         "onnx policy: images: expected an input for each of: none, got eye"),
    ]  # fmt: skip
    for options, text in cases:
        with pytest.raises(ConfigError) as caught:
            OnnxPolicy.check_options(skill, options)
        assert text in str(caught.value)


def test_without_onnxruntime_the_error_says_what_to_install(
    skills: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    skill, real = install(skills, linear(WEIGHTS)), builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name == "onnxruntime":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    assert refusal(skill) == (
        "onnx policy: the package onnxruntime is not installed: pip install 'fairlead[onnx]'"
    )


def test_the_numbers_of_two_arms_have_names_of_their_own() -> None:
    names = action_names(load_skill("dual-panda-lift"))
    assert len(set(names)) == len(names) == 19
    assert names[0] == "cartesian_twist left_tool[0]"
    assert names[12] == "cartesian_twist right_tool[5]"
    assert names[6] == "gripper_binary[0]" and names[18] == "dex_hand_joint[5]"


def test_a_mode_of_one_slot_is_named_as_in_files_that_exist() -> None:
    names = action_names(load_skill("bc-counter-to-cabinet"))
    assert names[:7] == (
        *(f"cartesian_delta[{index}]" for index in range(6)),
        "gripper_position[0]",
    )
