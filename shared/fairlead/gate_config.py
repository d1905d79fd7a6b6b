"""Compile a robot manifest into the one file the safety gate loads.

The text is deterministic and meant to be read: the committed ``gate.<profile>.json``
must equal it byte for byte (a test compares them), and its SHA-256 is the config hash in
statuses, leases and verdicts.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from pydantic import BaseModel

from fairlead.robot import RobotManifest
from fairlead.robot_joint import Joint
from fairlead.robot_part import Part
from fairlead.robot_safety import MeasuredLimits, SafetyProfile

FORMAT = "fairlead-gate-1"

Json = str | float | bool | Sequence["Json"] | dict[str, "Json"]

_UNIT_SUFFIXES = ("_rad_s", "_m_s", "_rad", "_m")


def compile_gate_config(robot: RobotManifest, profile: str) -> str:
    """The gate's configuration of one profile as JSON text, ending in a newline.

    Limits are SI: rad and m, per second where the name says velocity or standstill, per
    control period where it says jump or step.

    Raises:
        ConfigError: if the robot has no such profile.
    """
    safety = robot.profile(profile)
    config: dict[str, Json] = {
        "format": FORMAT,
        "robot": robot.id,
        "profile": profile,
        "robot_hash": robot.robot_hash.hex(),
        "period_ns": robot.tick_period_ns,
        "lockstep_allowed": safety.lockstep_allowed,
        "joints": [
            _joint(joint, _owner(robot, joint.name), safety.measured[joint.name])
            for joint in robot.joints
        ],
        "passive_joints": [
            _passive_joint(joint, safety.measured[joint.name]) for joint in robot.passive_joints
        ],
        "parts": [_part(part, safety) for part in robot.parts],
        "protocol": safety.protocol.model_dump(),
    }
    return json.dumps(config, indent=2, ensure_ascii=True, allow_nan=False) + "\n"


def _owner(robot: RobotManifest, joint: str) -> str:
    return next(part.name for part in robot.parts if joint in part.joints)


def _joint(joint: Joint, part: str, measured: MeasuredLimits) -> dict[str, Json]:
    return {
        "name": joint.name,
        "part": part,
        "kind": joint.type,
        **_bounds(joint, measured),
        "velocity_limit": joint.velocity_limit,
        "acceleration_limit": joint.acceleration_limit,
        "effort_limit": joint.effort_limit,
        "jump_limit": measured.jump_per_tick,
        "standstill_velocity": measured.standstill_per_s,
        "source": f"{joint.source}; measured state: {measured.source}",
    }


def _passive_joint(joint: Joint, measured: MeasuredLimits) -> dict[str, Json]:
    return {
        "name": joint.name,
        "jump_limit": measured.jump_per_tick,
        **_bounds(joint, measured),
        "standstill_velocity": measured.standstill_per_s,
        "source": f"{joint.source}; measured state: {measured.source}",
    }


def _bounds(joint: Joint, measured: MeasuredLimits) -> dict[str, Json]:
    if not joint.has_bounds or measured.tolerance is None:
        return {"zones": {"frame": "odom"}}
    return {
        "bounds": {
            "lower": joint.lower,
            "upper": joint.upper,
            "tolerance": measured.tolerance,
        }
    }


def _part(part: Part, safety: SafetyProfile) -> dict[str, Json]:
    limits = safety.parts[part.name]
    return {
        "name": part.name,
        "joints": list(part.joints),
        "modes": {name: _mode(getattr(limits, name)) for name in limits.names},
        "source": f"robot.yaml, part {part.name}",
    }


def _mode(limits: BaseModel) -> dict[str, Json]:
    """One mode's block: the units in robot.yaml's field names are implied in the gate."""
    return {_gate_name(name): value for name, value in limits.model_dump().items()}


def _gate_name(field: str) -> str:
    if field == "step_limits":
        return "step_limit"
    for suffix in _UNIT_SUFFIXES:
        if field.endswith(suffix):
            return field.removesuffix(suffix)
    return field
