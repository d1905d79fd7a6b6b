"""The effective limits of a robot: what the gate really enforces, after every factor.

A declared cap that a hidden factor has changed is a known trap, so this view is read
back from the compiled gate configuration, not from the manifest.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits


@dataclass(frozen=True)
class EffectiveLimit:
    """One enforced number.

    Attributes:
        where: ``joint NAME``, ``part NAME``, ``part NAME MODE``, ``self-collision``, ``base``,
            ``volume NAME``, ``zone NAME`` or ``protocol``.
        name: the limit, as in the compiled gate file.
        value: in ``unit``; a tuple where there is one number per joint of the part, axis or
            corner; words where the limit is a choice.
        source: where the number comes from.
    """

    where: str
    name: str
    value: float | tuple[float, ...] | str
    unit: str
    source: str


def surrounding_limits(config: dict[str, Any]) -> list[EffectiveLimit]:
    """Self-collision, volumes, the base and its zones, then the protocol."""
    collision, workspace, base = config["collision"], config["workspace"], config["base"]
    rows = [
        EffectiveLimit(
            "self-collision", "clearance", collision["clearance"], "m", collision["source"]
        ),
        EffectiveLimit(
            "self-collision", "pairs", float(len(collision["pairs"])), "1", collision["source"]
        ),
    ]
    for volume in workspace["volumes"]:
        where, source = f"volume {volume['name']}", workspace["source"]
        for end in ("lower", "upper"):
            name, ends = f"{volume['kind']} {end}", tuple(volume[end])
            rows.append(EffectiveLimit(where, name, ends, "m", source))
    return rows + _base_limits(base) + _protocol_limits(config["protocol"])


def _base_limits(base: dict[str, Any] | None) -> list[EffectiveLimit]:
    if base is None:
        return []
    source = base["source"]
    rows = [
        EffectiveLimit("base", "footprint", _flat(base["footprint"]), "m", source),
        EffectiveLimit("base", "yaw_axis", tuple(base["yaw_axis"]), "m", source),
        EffectiveLimit("base", "reaction_s", base["reaction_s"], "s", source),
        EffectiveLimit("base", "tool_drift", base["tool_drift"], "m", source),
        EffectiveLimit("base", "clearance_drift", base["clearance_drift"], "m", source),
    ]
    for zone in base["zones"]:
        where, name = f"zone {zone['name']}", f"{zone['kind']} corners"
        rows.append(EffectiveLimit(where, name, _flat(zone["corners"]), "m", source))
    return rows


def _flat(corners: list[list[float]]) -> tuple[float, ...]:
    return tuple(number for corner in corners for number in corner)


def _protocol_limits(protocol: dict[str, float]) -> list[EffectiveLimit]:
    rows = []
    for name, value in protocol.items():
        unit = name.rsplit("_", 1)[-1]
        unit = unit if unit in ("us", "ms", "s", "hz", "ticks") else "1"
        source = "robot.yaml, safety.protocol"
        rows.append(EffectiveLimit("protocol", name, float(value), unit, source))
    return rows


def effective_limits(robot: RobotManifest, profile: str = "sim") -> list[EffectiveLimit]:
    """Every limit of a profile in SI, joints first, each with its own source.

    Raises:
        ConfigError: if the robot has no such profile.
    """
    config = json.loads(compile_gate_config(robot, profile))
    measured = robot.profile(profile).measured
    rows: list[EffectiveLimit] = []
    for joint in config["joints"] + config["passive_joints"]:
        declared, where = robot.joint(joint["name"]), f"joint {joint['name']}"
        flat = {**(joint.pop("bounds", None) or {}), **joint}
        rows += _rows(where, flat, _range_units(declared.unit), declared.source)
        if declared in robot.joints:
            source = profile_limits(declared, robot.profile(profile))[3]
            rows += _rows(where, flat, _motion_units(declared.unit), source)
        state_units = _measured_units(declared.unit)
        rows += _rows(where, flat, state_units, measured[declared.name].source)
    for part in config["parts"]:
        rows += _part_rows(part)
        for mode, block in part["modes"].items():
            where = f"part {part['name']} {mode}"
            rows += _rows(where, block, _mode_units(mode, robot, part["joints"]), block["source"])
    return rows + surrounding_limits(config)


def _part_rows(part: dict[str, Any]) -> list[EffectiveLimit]:
    """What holds for all modes of a part; a part of one mode has none to change to."""
    where = f"part {part['name']}"
    rows = _rows(where, part, {"singularity_limit": "1"}, part["source"])
    if len(part["modes"]) > 1:
        pairs = ", ".join(" to ".join(pair) for pair in part["transitions"])
        rows.append(EffectiveLimit(where, "transitions", pairs or "none", "", part["source"]))
    return rows


def _rows(
    where: str, block: dict[str, object], units: dict[str, str], source: str
) -> list[EffectiveLimit]:
    rows = []
    for name, unit in units.items():
        value = block.get(name)
        if name == "slip_limit" and name in block and value is None:
            rows.append(EffectiveLimit(where, name, "no stop", "", source))
        elif isinstance(value, str):
            rows.append(EffectiveLimit(where, name, value, unit, source))
        elif isinstance(value, list):
            rows.append(EffectiveLimit(where, name, tuple(map(float, value)), unit, source))
        elif isinstance(value, int | float):
            rows.append(EffectiveLimit(where, name, float(value), unit, source))
    return rows


def _range_units(unit: str) -> dict[str, str]:
    return {"lower": unit, "upper": unit}


def _motion_units(unit: str) -> dict[str, str]:
    return {
        "velocity_limit": f"{unit}/s",
        "acceleration_limit": f"{unit}/s2",
        "effort_limit": _effort_unit(unit),
    }


def _effort_unit(unit: str) -> str:
    return "N" if unit == "m" else "N m"


def _measured_units(unit: str) -> dict[str, str]:
    return {
        "tolerance": unit,
        "jump_limit": f"{unit}/period",
        "standstill_velocity": f"{unit}/s",
        "contact_limit": _effort_unit(unit),
        "encoder_step": unit,
        "dead_band": f"{unit}/period",
        "stop_lag": "s",
    }


def _mode_units(mode: str, robot: RobotManifest, joints: list[str]) -> dict[str, str]:
    per_second = "/s" if mode in ("joint_velocity", "cartesian_twist", "body_twist") else ""
    if mode == "cartesian_pose":
        return {
            "lower": "m",
            "upper": "m",
            "linear_step_limit": "m",
            "angular_step_limit": "rad",
            "linear_tracking": "m",
            "angular_tracking": "rad",
        }
    if mode in ("cartesian_delta", "cartesian_twist", "body_twist"):
        names = ("limit", "step_limit", "tracking")
        linear = {f"linear_{name}": f"m{per_second}" for name in names}
        angular = {f"angular_{name}": f"rad{per_second}" for name in names}
        return {**linear, **angular, "gain": "1"}
    if mode == "gripper_position":
        unit = robot.joint(joints[0]).unit
        return dict.fromkeys(("lower", "upper", "step_limit", "slip_limit"), unit)
    if mode == "composite_mode":
        return {"step_limit": "1", "switching": ""}
    units_of_joints = dict.fromkeys(robot.joint(name).unit + per_second for name in joints)
    unit = ", ".join(units_of_joints)
    return {"step_limit": unit, "tracking": unit, "gain": "1"}
