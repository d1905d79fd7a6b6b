"""A skill's own limits against the robot's: they may tighten, never loosen.

The gate decides at the claim; this says the same beforehand, for every profile, so that
a skill is not refused only once it runs.
"""

from __future__ import annotations

import json
from typing import Any

from fairlead.gate_config import compile_gate_config
from fairlead.robot import RobotManifest
from fairlead.skill import SkillLimit, SkillManifest

_NOT_A_LIMIT = ("source", "frames", "free_axes")


def limit_problems(skill: SkillManifest, robot: RobotManifest) -> list[str]:
    """Every way the skill asks for more than a profile of the robot allows."""
    problems = []
    for profile in robot.safety:
        config = json.loads(compile_gate_config(robot, profile))
        blocks = {part["name"]: part["modes"] for part in config["parts"]}
        found = [
            *_protocol_problems(skill, config["protocol"]),
            *(text for limit in skill.limits for text in _override_problems(limit, blocks)),
        ]
        problems += [f"{text} (profile {profile})" for text in found]
    return problems


def _protocol_problems(skill: SkillManifest, protocol: dict[str, Any]) -> list[str]:
    asked = (
        ("horizon", skill.horizon, protocol["horizon_max"]),
        ("age_max_ticks", skill.age_max_ticks, protocol["age_max_ticks"]),
        ("rate_hz", skill.rate_hz, protocol["chunk_rate_max_hz"]),
    )
    return [
        f"{name}: expected at most {limit:g}, got {value:g}"
        for name, value, limit in asked
        if value > limit
    ]


def _override_problems(limit: SkillLimit, blocks: dict[str, Any]) -> list[str]:
    where = f"limits: {limit.part} {limit.control_mode} {limit.name}"
    block = blocks.get(limit.part, {}).get(limit.control_mode)
    if block is None:
        valid = "; ".join(f"{part}: {', '.join(modes)}" for part, modes in blocks.items())
        return [f"{where}: no such part and mode (valid: {valid})"]
    names = [name for name in block if name not in _NOT_A_LIMIT]
    if limit.name not in names:
        return [f"{where}: no such limit (valid: {', '.join(names)})"]
    lower, upper = _allowed(limit.name, block)
    if lower <= limit.value <= upper and (limit.value > 0 or limit.name in ("lower", "upper")):
        return []
    floor = f"at least {lower:g}" if limit.name in ("lower", "upper") else "above 0"
    return [f"{where}: expected {floor} and at most {upper:g}, got {limit.value:g}"]


def _allowed(name: str, block: dict[str, Any]) -> tuple[float, float]:
    """The values that do not loosen: an upper bound may only fall, a lower one only rise."""
    if name in ("lower", "upper"):
        return float(block["lower"]), float(block["upper"])
    value = block[name]
    return 0.0, float(min(value)) if isinstance(value, list) else float(value)
