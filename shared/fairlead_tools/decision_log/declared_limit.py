"""Which key of robot.yaml declares the limit that a verdict names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from fairlead_tools.decision_log.explanation import Judged

_ABSOLUTE, _BRAKING = 20, 24
_STEPS = (21, 22, 23)
_SHARED = {31: "workspace", 32: "self_collision.clearance"}
"""Codes whose limit is no single part's, and its key."""
_SUFFIXES = ("", "_m", "_rad", "_m_s", "_rad_s", "_n", "_nm")


@dataclass(frozen=True)
class DeclaredLimit:
    """A key, ``safety.sim.parts.arm.cartesian_delta.linear_limit_m``, and its number.

    ``number`` is None where the key has a list or the number is not the verdict's alone.
    """

    file: Path
    key: str
    number: float | None


def declared_limit(
    config_file: Path, profile: str, verdict: Judged, mode: str
) -> DeclaredLimit | None:
    """The key behind a verdict of G020 to G034; None if robot.yaml has none that is certain.

    Args:
        config_file: the compiled gate file; robot.yaml lies beside it.
        mode: control mode of the verdict's part, by its name in YAML.
    """
    file = config_file.parent / "robot.yaml"
    if verdict.code < _ABSOLUTE or not mode or not file.is_file():
        return None
    robot = _as_it_is_now(file)
    for path in _candidates(robot, profile, verdict, mode):
        found: Any = robot
        for name in path.split("."):
            found = _child(found, name)
        if found is not None:
            number = float(found) if isinstance(found, int | float) else None
            return DeclaredLimit(file, path, number)
    return None


def _as_it_is_now(file: Path) -> dict[str, Any]:
    """A robot.yaml that is being edited may not be one at the moment: {} then."""
    try:
        robot = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        return {}
    return robot if isinstance(robot, dict) else {}


def _child(node: Any, name: str) -> Any:
    if isinstance(node, list):  # joints, by their names
        named = (item for item in node if isinstance(item, dict))
        return next((item for item in named if item.get("name") == name), None)
    return node.get(name) if isinstance(node, dict) else None


def _candidates(robot: dict[str, Any], profile: str, verdict: Judged, mode: str) -> list[str]:
    """Keys that may declare it, in the units a manifest can have; at most one exists."""
    is_joint = _child(robot.get("joints") or [], verdict.axis) is not None
    stems = _stems(f"safety.{profile}", verdict, mode, is_joint)
    return [f"{stem}{suffix}" for stem in stems for suffix in _SUFFIXES]


def _stems(profile: str, verdict: Judged, mode: str, is_joint: bool) -> list[str]:
    part = f"{profile}.parts.{verdict.part}"
    if verdict.code in _SHARED:
        return [f"{profile}.{_SHARED[verdict.code]}"]
    if verdict.code == 33:
        return [f"{part}.singularity_limit"]
    if verdict.code == 34:
        return [f"{profile}.base.zones.{verdict.axis}"]
    if verdict.code in _STEPS:
        norm = verdict.axis in ("linear", "angular")
        names = [f"{verdict.axis}_step_limit"] if norm else ["step_limits", "step_limit"]
        return [f"{part}.{mode}.{name}" for name in names]
    if verdict.code not in (_ABSOLUTE, _BRAKING):
        return []
    side = "upper" if _is_above(verdict) else "lower"
    if is_joint:
        what = "velocity" if mode == "joint_velocity" else side
        return [f"joints.{verdict.axis}.{side if verdict.code == _BRAKING else what}"]
    if verdict.axis in ("linear", "angular"):
        return [f"{part}.{mode}.{verdict.axis}_limit"]
    return [f"{part}.{mode}.{side}"] if verdict.axis in ("opening", "x", "y", "z") else []


def _is_above(verdict: Judged) -> bool:
    numbers = isinstance(verdict.value, float) and isinstance(verdict.limit, float)
    return not numbers or float(verdict.value) > float(verdict.limit)
