"""What the arrays of a recorded episode's file must be."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest

PICTURE = "picture_"
"""Before the name of a picture."""

TICKS, _COLOURS = "ticks", "colours"
_FORMS = {
    "states": ("float64", (TICKS, "dim")),
    "rows": ("float32", (TICKS, "action dim")),
    "acted": ("float32", (TICKS, "action dim")),
    "labels": ("float32", (TICKS, "horizon", "action dim")),
    "released": ("bool", (TICKS,)),
}
"""By array its numbers and axes."""


def _form(name: str) -> tuple[str, tuple[str, ...]]:
    return _FORMS.get(name, ("uint8", (TICKS, f"{name} height", f"{name} width", _COLOURS)))


def sizes_of(skill: SkillManifest) -> dict[str, int]:
    """How long the axes of a skill's episodes are, but for the ticks."""
    sizes = {
        "dim": skill.state_contract.dim,
        "action dim": skill.action_contract.dim,
        "horizon": skill.horizon,
    }
    for name, spec in skill.images.items():
        height, width = spec.shape[:2] if spec.axes == "hwc" else spec.shape[1:]
        sizes |= {f"{PICTURE}{name} height": height, f"{PICTURE}{name} width": width}
    return sizes


def check_array(
    who: str, name: str, array: npt.NDArray[Any], sizes: dict[str, int], may_lack: bool
) -> None:
    """Let an array of an episode pass.

    Args:
        sizes: how long each axis is, as far as is known; those of the array are added.
        may_lack: NaN stands for a number that is not there.

    Raises:
        ConfigError: other numbers or another shape than the array's name says, nothing in it, or
            numbers that are not finite.
    """
    numbers, axes = _form(name)
    wanted = [3 if axis == _COLOURS else sizes.get(axis, "N") for axis in axes]
    fits = array.ndim == len(wanted) and all(
        have == want if isinstance(want, int) else have > 0
        for have, want in zip(array.shape, wanted, strict=True)
    )
    if array.dtype.name != numbers or not fits:
        form = f"{numbers} [{', '.join(map(str, wanted))}]"
        raise ConfigError(expected(who, form, f"{array.dtype} {list(array.shape)}"))
    sizes.update(zip(axes, array.shape, strict=True))
    if not may_lack and array.dtype.kind == "f" and not np.isfinite(array).all():
        place = tuple(np.argwhere(~np.isfinite(array))[0])
        got = f"{array[place]} in tick {place[0]}"
        raise ConfigError(expected(who, "finite numbers", got))
