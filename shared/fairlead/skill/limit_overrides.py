"""A skill's own limits against the robot's: they may tighten, never loosen.

The gate decides at the claim; this says the same beforehand, so that a skill is not refused
only once it runs.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterable
from typing import Any

from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillLimit, SkillManifest

Range = tuple[float, float]

_OF_THE_ROBOT = (
    "gain",
    "tracking",
    "linear_tracking",
    "angular_tracking",
    "slip_limit",
    "switching",
)
_NOT_A_LIMIT = ("source", "frames", "free_axes", *_OF_THE_ROBOT)
"""Keys of a mode that a claim cannot tighten: they say what the robot does, not what it may."""

_OF_THE_JOINTS = {"joint_velocity": "velocity_limit"}
"""A mode's limit that is the joints' own: a claim gives one number for all of them."""


def limit_problems(skill: SkillManifest, robot: RobotManifest, profile: str) -> list[str]:
    """Every way the skill asks for more than a safety profile of the robot allows."""
    config = _gate_file(robot, profile)
    found = [
        *_protocol_problems(skill, robot.tick_period_ns, config["protocol"]),
        *override_problems(skill.limits, config),
    ]
    return [f"{text} (profile {profile})" for text in found]


def _gate_file(robot: RobotManifest, profile: str) -> dict[str, Any]:
    """Compiled once, however many skills are held against it.

    By identity: one that is loaded anew may be equal and have other files.
    """
    for one, its_profile, config in tuple(_KEPT):
        if one is robot and its_profile == profile:
            return config
    compiled: dict[str, Any] = json.loads(compile_gate_config(robot, profile))
    _KEPT.append((robot, profile, compiled))
    return compiled


_KEPT: deque[tuple[RobotManifest, str, dict[str, Any]]] = deque(maxlen=8)


def override_problems(limits: Iterable[SkillLimit], config: dict[str, Any]) -> list[str]:
    """Every one of a claim's limits that a gate with this gate file refuses, in words.

    Taken one after the other, as the gate does: one that fits narrows the room of the next.
    """
    blocks = {part["name"]: _ranges(part, config["joints"]) for part in config["parts"]}
    return [text for limit in limits for text in _problems_of(limit, blocks)]


def _protocol_problems(skill: SkillManifest, period_ns: int, protocol: dict[str, Any]) -> list[str]:
    periods = skill.control_periods(period_ns) or 1
    rows = "horizon" if periods == 1 else f"horizon, {periods} control periods a row"
    asked = (
        (rows, skill.horizon * periods, protocol["horizon_max"]),
        ("age_max_ticks", skill.age_max_ticks, protocol["age_max_ticks"]),
        ("chunks a second, one a period", 1e9 / period_ns, protocol["chunk_rate_max_hz"]),
    )
    return [
        f"{name}: expected at most {limit:g}, got {value:g}"
        for name, value, limit in asked
        if value > limit
    ]


def _problems_of(limit: SkillLimit, blocks: dict[str, dict[str, Any]]) -> list[str]:
    where = f"limits: {limit.part} {limit.control_mode} {limit.name}"
    ranges = blocks.get(limit.part, {}).get(limit.control_mode)
    if ranges is None:
        valid = "; ".join(f"{part}: {', '.join(modes)}" for part, modes in blocks.items())
        return [f"{where}: no such part and mode (valid: {valid})"]
    if limit.name not in ranges:
        return [f"{where}: no such limit (valid: {', '.join(ranges) or 'none'})"]
    lower, upper = ranges[limit.name]
    if limit.name.startswith("lower"):
        fits, room = lower <= limit.value < upper, f"at least {lower:g} and below upper, {upper:g}"
    elif limit.name.startswith("upper"):
        fits, room = lower < limit.value <= upper, f"above lower, {lower:g}, and at most {upper:g}"
    else:
        fits, room = lower < limit.value <= upper, f"above {lower:g} and at most {upper:g}"
    if not fits:
        return [f"{where}: expected {room}, got {limit.value:g}"]
    _narrow(ranges, limit)
    return []


def _narrow(ranges: dict[str, Range], limit: SkillLimit) -> None:
    """A limit that was taken is what the next one is measured by; two ends bound each other."""
    lower, upper = ranges[limit.name]
    if limit.name.startswith("lower"):
        opposite = limit.name.replace("lower", "upper")
        ranges[limit.name] = ranges[opposite] = (limit.value, upper)
    elif limit.name.startswith("upper"):
        opposite = limit.name.replace("upper", "lower")
        ranges[limit.name] = ranges[opposite] = (lower, limit.value)
    else:
        ranges[limit.name] = (lower, limit.value)


def _ranges(part: dict[str, Any], joints: list[dict[str, Any]]) -> dict[str, dict[str, Range]]:
    """For each mode of a part, the values of each limit that do not loosen it."""
    own = [joint for joint in joints if joint["name"] in part["joints"]]
    ranges = {mode: _block_ranges(block) for mode, block in part["modes"].items()}
    for mode, name in _OF_THE_JOINTS.items():
        if mode in ranges:
            ranges[mode][name] = (0.0, min(joint[name] for joint in own))
    if "composite_mode" in ranges:  # its range is its definition, not in the file
        ranges["composite_mode"] |= {"lower": (-1.0, 1.0), "upper": (-1.0, 1.0)}
    return ranges


def _block_ranges(block: dict[str, Any]) -> dict[str, Range]:
    """An upper bound may only fall, a lower one only rise; a box has one of each per axis."""
    ranges: dict[str, Range] = {}
    for name, value in block.items():
        if name in _NOT_A_LIMIT:
            continue
        if name not in ("lower", "upper"):
            ranges[name] = (0.0, min(value) if isinstance(value, list) else value)
        elif isinstance(value, list):
            ends = zip("xyz", block["lower"], block["upper"], strict=True)
            ranges |= {f"{name}_{axis}": (lower, upper) for axis, lower, upper in ends}
        else:
            ranges[name] = (block["lower"], block["upper"])
    return ranges
