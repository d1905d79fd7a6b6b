"""A policy in an ONNX file of the skill's folder: onnxruntime, one thread, always the same bits."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.paths import rskill_dir
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.onnx_files import (
    WHO,
    HashedFile,
    Normaliser,
    Statistics,
    read_normalisers,
)
from fairlead_skill_runner.policies.remote.served_policy import warm_up_observation

if TYPE_CHECKING:
    import onnxruntime

Shape = tuple[int, ...]
_WEIGHTS_FOLDER = "session.model_external_initializers_file_folder_path"
_DTYPES = {"tensor(float)": "float32", "tensor(uint8)": "uint8"}


class OnnxOptions(BaseModel):
    """The policy's files and the names of its inputs and its output.

    Attributes:
        statistics: None: state and actions go in and out as they are.
        state: input, float32 ``[1, dim]``.
        actions: output, float32 ``[1, H, dim]``, H at most the skill's horizon.
        images: each of the skill's pictures -> its input: one more axis before those that the
            skill declares, and another of its frames where it has several deltas.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    model: HashedFile
    statistics: Statistics | None = None
    state: str = "state"
    actions: str = "actions"
    images: dict[str, str] = Field(default_factory=dict)


class _Input(NamedTuple):
    dtype: str
    shape: Shape


class OnnxPolicy:
    """Normalises, runs the network, restores; the same observation gives the same bits."""

    def __init__(
        self,
        skill: SkillManifest,
        options: OnnxOptions,
        session: onnxruntime.InferenceSession,
        normalisers: tuple[Normaliser, Normaliser] | None,
    ) -> None:
        self._skill, self._options, self._session = skill, options, session
        self._normalisers = normalisers

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit the skill; no file is read."""
        check_onnx_options(skill, options)

    @classmethod
    def check_files(
        cls, skill: SkillManifest, options: Mapping[str, JsonValue], folder: Path
    ) -> None:
        """Raises `ConfigError` for files that are missing, others, or do not fit the skill."""
        _read_files(folder, check_onnx_options(skill, options), skill)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Read the files, compare inputs and output with the skill's contracts, run once.

        Raises:
            ConfigError: for options, files, inputs or an output that do not fit.
            PolicyError: if the network fails or says anything but rows of finite numbers.
        """
        checked, folder = check_onnx_options(skill, options), rskill_dir(skill.id)
        data, normalisers = _read_files(folder, checked, skill)
        session = _session(str(folder / checked.model.file), data)
        _check_inputs(session, wanted_inputs(skill, checked))
        _check_output(session, checked, skill)
        policy = cls(skill, checked, session, normalisers)
        policy.infer(warm_up_observation(skill))
        return policy

    def infer(self, observation: Observation) -> Actions:
        """The network's rows, float32 ``[H, dim]``.

        Raises:
            PolicyError: if it fails or says anything else.
        """
        options, state = self._options, observation.state
        if self._normalisers is not None:
            state = self._normalisers[0].normalised(state)
        feeds: dict[str, npt.NDArray[Any]] = {options.state: state.astype(np.float32)[None]}
        for name, given in options.images.items():
            several = len(self._skill.images[name].deltas) > 1
            array = observation.frames_of(name) if several else observation.images[name]
            feeds[given] = array[None]
        try:
            (output,) = self._session.run([options.actions], feeds)
        except Exception as error:  # noqa: BLE001 - onnxruntime's own have no common base
            raise PolicyError(f"{WHO}: {options.model.file} failed: {error}") from None
        rows = np.asarray(output)[0]
        dim, horizon = self._skill.action_contract.dim, self._skill.horizon
        if self._normalisers is not None:
            rows = self._normalisers[1].restored(rows.astype(np.float64))
        return float_rows(WHO, options.actions, rows, dim, horizon)

    def reset(self) -> None:
        """Nothing to forget."""


def _read_files(
    folder: Path, options: OnnxOptions, skill: SkillManifest
) -> tuple[bytes, tuple[Normaliser, Normaliser] | None]:
    data, statistics = options.model.read(folder), options.statistics
    return data, None if statistics is None else read_normalisers(folder, statistics, skill)


def check_onnx_options(skill: SkillManifest, options: Mapping[str, JsonValue]) -> OnnxOptions:
    """The options of an ONNX policy.

    Raises:
        ConfigError: for options that do not fit, alone or with the skill's pictures.
    """
    checked = checked_model(WHO, OnnxOptions, options)
    if set(checked.images) != set(skill.images):
        wanted = ", ".join(skill.images) or "none"
        got = ", ".join(checked.images) or "none"
        raise ConfigError(expected(f"{WHO}: images", f"an input for each of: {wanted}", got))
    inputs = [checked.state, *checked.images.values()]
    if len(set(inputs)) < len(inputs):
        raise ConfigError(expected(f"{WHO}: inputs", "different names", ", ".join(inputs)))
    return checked


def wanted_inputs(skill: SkillManifest, options: OnnxOptions) -> Mapping[str, _Input]:
    """By name, what the network has to take."""
    wanted = {options.state: _Input("float32", (1, skill.state_contract.dim))}
    for name, given in options.images.items():
        spec = skill.images[name]
        frames = (len(spec.deltas),) if len(spec.deltas) > 1 else ()
        wanted[given] = _Input(str(spec.number_type), (1, *frames, *spec.shape))
    return wanted


def _session(path: str, data: bytes) -> onnxruntime.InferenceSession:
    try:
        import onnxruntime as runtime
    except ImportError:
        who = f"{WHO}: the package onnxruntime"
        raise ConfigError(f"{who} is not installed: pip install 'fairlead[onnx]'") from None
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.execution_mode = runtime.ExecutionMode.ORT_SEQUENTIAL
    options.use_deterministic_compute = True
    options.log_severity_level = 3
    # Weights in another file would be in no hash: nowhere is none.
    options.add_session_config_entry(_WEIGHTS_FOLDER, os.devnull)
    try:
        return runtime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # noqa: BLE001 - onnxruntime's own have no common base
        what = "no ONNX model that can be run, or its weights are in another file"
        raise ConfigError(f"{WHO}: {path}: {what}: {error}") from None


def _check_inputs(session: onnxruntime.InferenceSession, wanted: Mapping[str, _Input]) -> None:
    """Raises `ConfigError` unless the network takes exactly what the skill gives."""
    found = {one.name: one for one in session.get_inputs()}
    if set(found) != set(wanted):
        raise ConfigError(
            expected(f"{WHO}: inputs of the model", ", ".join(wanted), ", ".join(found))
        )
    for name, one in found.items():
        dtype, shape = _DTYPES.get(one.type, one.type), wanted[name].shape
        if dtype != wanted[name].dtype or not _fits(one.shape, shape):
            raise ConfigError(
                expected(
                    f"{WHO}: input {name}",
                    f"{wanted[name].dtype} {list(shape)}",
                    f"{dtype} {list(one.shape)}",
                )
            )


def _check_output(
    session: onnxruntime.InferenceSession, options: OnnxOptions, skill: SkillManifest
) -> None:
    found = {one.name: one for one in session.get_outputs()}
    if options.actions not in found:
        raise ConfigError(
            expected(f"{WHO}: the model", f"an output {options.actions}", "none", found)
        )
    one, dim = found[options.actions], skill.action_contract.dim
    rows = one.shape[1] if len(one.shape) == 3 else 0
    rows = rows if isinstance(rows, int) else 1  # one that is not fixed is checked in each answer
    fits = _fits(one.shape, (1, rows, dim)) and 1 <= rows <= skill.horizon
    if one.type != "tensor(float)" or not fits:
        wanted = f"float32 [1, 1 to {skill.horizon}, {dim}]"
        got = f"{_DTYPES.get(one.type, one.type)} {list(one.shape)}"
        raise ConfigError(expected(f"{WHO}: output {options.actions}", wanted, got))


def _fits(declared: Sequence[object], wanted: Shape) -> bool:
    """An axis that the model names instead of sizing takes any size."""
    return len(declared) == len(wanted) and all(
        not isinstance(size, int) or size == want
        for size, want in zip(declared, wanted, strict=True)
    )
