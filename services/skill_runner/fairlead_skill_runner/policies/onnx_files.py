"""The files of an ONNX policy, in the skill's folder: its network, and its normaliser statistics.

Both are known by their SHA-256, which the skill states: another file of the same name is refused.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.regular_file import regular
from fairlead.skill.manifest import SkillManifest

WHO = "onnx policy"
_EPSILON = 1e-8  # LeRobot's, below a spread of 0
_QUANTILE_EPSILON = 1e-6  # openpi's, in each spread and both ways
Form = Literal["mean_std", "min_max", "quantiles"]
_PAIRS: dict[Form, tuple[str, str]] = {
    "mean_std": ("mean", "std"),
    "min_max": ("min", "max"),
    "quantiles": ("q01", "q99"),
}


class HashedFile(BaseModel):
    """A file of the skill's folder and its SHA-256 in lower-case hexadecimal digits."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: str = Field(pattern=r"^[^/\\]+$")
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")

    def read(self, folder: Path) -> bytes:
        """Its bytes.

        Raises:
            ConfigError: it cannot be read, or is another file.
        """
        path = folder / self.file
        try:
            data = regular(path).read_bytes()
        except OSError as error:
            raise ConfigError(f"{WHO}: {path}: cannot be read: {error.strerror}") from None
        found = hashlib.sha256(data).hexdigest()
        if found != self.sha256:
            raise ConfigError(expected(f"{WHO}: {path}", f"SHA-256 {self.sha256}", found))
        return data


class Statistics(HashedFile):
    """How the training's statistics normalise.

    form: ``mean_std``: (x - mean) / std; ``min_max``: min to -1 and max to 1; ``quantiles``: q01 to
        -1 and q99 to 1, as in openpi. A dimension that never moved becomes 0 by the first and -1 by
        the others, as in LeRobot and openpi.
    """

    form: Form


class _Block(BaseModel):
    """One feature of the file: a name and two numbers for each dimension."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    names: tuple[str, ...]
    mean: tuple[float, ...] = ()
    std: tuple[float, ...] = ()
    min: tuple[float, ...] = ()
    max: tuple[float, ...] = ()
    q01: tuple[float, ...] = ()
    q99: tuple[float, ...] = ()


@dataclass(frozen=True)
class Normaliser:
    """``normalised = (value - start) / divisor + shift``, as LeRobot has it; float64 ``[dim]``.

    spread: what the way back multiplies by: the divisor, of ``mean_std`` before anything was added.
    """

    start: FloatArray
    divisor: FloatArray
    spread: FloatArray
    shift: float

    @classmethod
    def of(cls, form: Form, one: FloatArray, other: FloatArray) -> Self:
        """Of mean and standard deviation, or of least and most, each float64 ``[dim]``.

        Quantiles are taken as least and most.
        """
        if form == "mean_std":
            return cls(one, other + _EPSILON, other, 0.0)
        if form == "quantiles":
            range_ = other - one + _QUANTILE_EPSILON
        else:
            range_ = np.where(other == one, _EPSILON, other - one)
        return cls(one, range_ / 2, range_ / 2, -1.0)

    def normalised(self, values: FloatArray) -> FloatArray:
        """Of values ``[..., dim]``."""
        return (values - self.start) / self.divisor + self.shift

    def restored(self, values: FloatArray) -> FloatArray:
        """The other way, in the policy's own numbers."""
        return (values - self.shift) * self.spread + self.start


def state_names(skill: SkillManifest) -> tuple[str, ...]:
    """What the statistics call each number of the state: the layout and its index."""
    return tuple(
        f"{skill.state_contract.layout_name}[{index}]" for index in range(skill.state_contract.dim)
    )


def action_names(skill: SkillManifest) -> tuple[str, ...]:
    """What they call each number of an action: its mode and a count of that mode's numbers.

    Where several slots have one mode, also whose it is: an end effector, or a joint.
    """
    contract = skill.action_contract
    names = [f"discard[{index}]" for index in range(contract.dim)]
    slots = Counter(slot.control_mode for slot in contract.routed)
    counted: Counter[str] = Counter()
    for slot in contract.routed:
        for index in range(slot.width):
            name = f"{slot.control_mode}"
            if slots[slot.control_mode] > 1:
                whose = slot.joint_names[index] if slot.joint_names else slot.ee
                name += f" {whose}" if whose else ""
            names[slot.first + index] = f"{name}[{counted[name]}]"
            counted[name] += 1
    return tuple(names)


def read_normalisers(
    folder: Path, statistics: Statistics, skill: SkillManifest
) -> tuple[Normaliser, Normaliser]:
    """Of state and action, from a file like LeRobot's ``stats.json`` with names.

    Raises:
        ConfigError: it is another file, or its names or sizes are not the skill's.
    """
    where = f"{WHO}: {folder / statistics.file}"
    try:
        document = json.loads(statistics.read(folder))
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{where}: not JSON: {error}") from None
    if not isinstance(document, dict):
        raise ConfigError(expected(where, "a map", type(document).__name__))
    wanted = (("observation.state", state_names(skill)), ("action", action_names(skill)))
    state, action = (
        _normaliser(f"{where}: {key}", document.get(key), names, statistics.form)
        for key, names in wanted
    )
    return state, action


def _normaliser(where: str, block: object, names: tuple[str, ...], form: Form) -> Normaliser:
    if not isinstance(block, dict):
        raise ConfigError(expected(where, "a map of names and statistics", type(block).__name__))
    read = checked_model(where, _Block, block)
    if read.names != names:
        raise ConfigError(expected(f"{where}.names", _listed(names), _listed(read.names)))
    pair = _PAIRS[form]
    first, second = (_numbers(f"{where}.{key}", getattr(read, key), len(names)) for key in pair)
    below = second if form == "mean_std" else second - first
    if (below < 0).any():
        index = int(np.argmin(below))
        least = "0" if form == "mean_std" else f"{pair[0]}, {first[index]:g}"
        what = f"{pair[1]} of {names[index]} at least {least}"
        raise ConfigError(expected(where, what, f"{second[index]:g}"))
    return Normaliser.of(form, first, second)


def _numbers(where: str, values: tuple[float, ...], count: int) -> FloatArray:
    numbers = np.array(values, dtype=np.float64)
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ConfigError(expected(where, f"{count} finite numbers", list(values) or "none"))
    return numbers


def _listed(names: tuple[str, ...]) -> str:
    return f"{len(names)} names: {', '.join(names)}"
