"""Small ONNX policies and the skills that name them, in a folder of the test's own."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import yaml
from onnx import TensorProto, helper, numpy_helper

from fairlead.errors import ConfigError, PolicyError
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest, load_skill, read_skill
from fairlead_skill_runner.policies.onnx import OnnxPolicy
from fairlead_skill_runner.policies.onnx_files import action_names, state_names

DIM, STATE, HORIZON = 12, 30, 4
NAME = "onnx-test"
_RNG = np.random.default_rng(2)
WEIGHTS = _RNG.normal(size=(STATE, HORIZON * DIM)).astype(np.float32)
SEEN = Observation(1, _RNG.normal(size=STATE), "")


def made(skill: SkillManifest) -> OnnxPolicy:
    return OnnxPolicy.from_options(skill, skill.policy.options)


def refusal(skill: SkillManifest) -> str:
    with pytest.raises((ConfigError, PolicyError)) as caught:
        made(skill)
    return str(caught.value)


def values(name: str, dtype: int, shape: Sequence[int | str]) -> Any:
    return helper.make_tensor_value_info(name, dtype, list(shape))


def model(
    nodes: Sequence[Any], inputs: Sequence[Any], outputs: Sequence[Any], **constants: np.ndarray
) -> bytes:
    """A checked model; its version is one that older runtimes take too."""
    initial = [numpy_helper.from_array(value, name) for name, value in constants.items()]
    graph = helper.make_graph(list(nodes), "test", list(inputs), list(outputs), initial)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(made)
    data: bytes = made.SerializeToString()
    return data


def linear(weights: np.ndarray, state: int = STATE, dtype: int = TensorProto.FLOAT) -> bytes:
    """``actions = state @ weights`` as rows ``[1, HORIZON, DIM]``; weights [state, 48]."""
    return model(
        [
            helper.make_node("MatMul", ["state", "w"], ["flat"]),
            helper.make_node("Reshape", ["flat", "shape"], ["actions"]),
        ],
        [values("state", dtype, [1, state])],
        [values("actions", dtype, [1, HORIZON, DIM])],
        w=weights,
        shape=np.array([1, HORIZON, DIM], np.int64),
    )


def poisonous(rows: np.ndarray) -> bytes:
    """Rows of 0.25, and ``rows`` [HORIZON, DIM] once the state's first number is above 1."""
    return model(
        [
            helper.make_node("Slice", ["state", "zero", "first", "axis"], ["begin"]),
            helper.make_node("Greater", ["begin", "limit"], ["is_late"]),
            helper.make_node("Where", ["is_late", "rows", "fine"], ["wide"]),
            helper.make_node("Reshape", ["wide", "shape"], ["actions"]),
        ],
        [values("state", TensorProto.FLOAT, [1, STATE])],
        [values("actions", TensorProto.FLOAT, [1, HORIZON, DIM])],
        zero=np.array([0], np.int64),
        first=np.array([1], np.int64),
        axis=np.array([1], np.int64),
        limit=np.ones((1, 1), np.float32),
        rows=rows.astype(np.float32).reshape(1, -1),
        fine=np.full((1, HORIZON * DIM), 0.25, np.float32),
        shape=np.array([1, HORIZON, DIM], np.int64),
    )


def statistics(skill: SkillManifest, **changes: Any) -> dict[str, Any]:
    """Of a skill, seeded; ``changes`` replace blocks."""
    rng = np.random.default_rng(5)
    made = {}
    for key, names in (("observation.state", state_names(skill)), ("action", action_names(skill))):
        low, spread = rng.normal(size=len(names)), rng.uniform(0.1, 2, len(names))
        made[key] = {
            "names": list(names), "mean": low.tolist(), "std": spread.tolist(),
            "min": low.tolist(), "max": (low + spread).tolist(),
            "q01": (low + 0.1 * spread).tolist(), "q99": (low + 0.8 * spread).tolist(),
        }  # fmt: skip
    return made | changes


def install(
    skills: Path,
    data: bytes,
    stats: object = None,
    form: str = "mean_std",
    images: dict[str, Any] | None = None,
    **options: Any,
) -> SkillManifest:
    """Write the skill ``onnx-test`` below ``skills`` (FAIRLEAD_SKILLS); images: input, spec."""
    folder = skills / NAME
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "policy.onnx").write_bytes(data)
    given: dict[str, Any] = {"model": _hashed("policy.onnx", data)}
    if stats is not None:
        text = stats if isinstance(stats, bytes) else json.dumps(stats).encode()
        (folder / "stats.json").write_bytes(text)
        given["statistics"] = _hashed("stats.json", text) | {"form": form}
    document = load_skill("oracle-counter-to-cabinet").model_dump(mode="json", exclude_none=True)
    if images:
        given["images"] = {name: one["input"] for name, one in images.items()}
        document["images"] = {name: one["spec"] for name, one in images.items()}
    document |= {
        "id": NAME, "model_family": "test", "horizon": HORIZON, "execute_steps": HORIZON,
        "policy": {"backend": "onnx", "options": given | options},
    }  # fmt: skip
    (folder / "rskill.yaml").write_text(yaml.safe_dump(document))
    return read_skill(folder)


def _hashed(file: str, data: bytes) -> dict[str, str]:
    return {"file": file, "sha256": hashlib.sha256(data).hexdigest()}
