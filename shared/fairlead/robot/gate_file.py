"""Compile a robot manifest into the one file the safety gate loads.

The text is deterministic and meant to be read: the committed ``gate.<profile>.json``
must equal it byte for byte (a test compares them), and its SHA-256 is the config hash in
statuses, leases and verdicts.
"""

from __future__ import annotations

import hashlib
import json
import re

from pydantic import BaseModel

from fairlead.errors import ConfigError, expected
from fairlead.paths import robot_dir
from fairlead.robot.capsules import CapsuleFile, load_capsules
from fairlead.robot.description import DescriptionTree, Link, description_tree
from fairlead.robot.executed_way import limits_for_the_gate
from fairlead.robot.gate_geometry import (
    Json,
    check_bare_links,
    compiled_base,
    compiled_shape,
    compiled_workspace,
    is_swept,
)
from fairlead.robot.home_check import check_home
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.robot.possible_limits import check_possible
from fairlead.robot.safety_profile import MeasuredLimits, SafetyProfile, profile_limits

FORMAT = "fairlead-gate-1"

_NUMBER_LIST = re.compile(r"\[\s+(-?\d[^\[\]\"{}]*?)\s+\]")
_UNIT_SUFFIXES = ("_rad_s", "_m_s", "_rad", "_m")
_GATE_NAMES = {"step_limits": "step_limit", "tracking_limits": "tracking"}


def compile_gate_config(robot: RobotManifest, profile: str) -> str:
    """The gate's configuration of one profile as JSON text, ending in a newline.

    Limits are SI: rad and m, per second where the name says velocity or standstill, per
    control period where it says jump or step.

    Raises:
        ConfigError: if the robot has no such profile, or its description is not one tree of
            measured joints, or lacks a frame that a mode or an end effector names; if a link has
            no capsule and robot.yaml does not say why; if a limit is beyond what the robot can do;
            if a source or a name is longer than the
            gate keeps, or a list longer than it has room for.
    """
    tree = description_tree(robot)
    capsules = load_capsules(robot)
    safety = limits_for_the_gate(robot, profile, tree, capsules)
    _check_frames(robot, safety, tree, capsules)
    config: dict[str, Json] = {
        "format": FORMAT,
        "robot": robot.id,
        "profile": profile,
        "robot_hash": robot.robot_hash.hex(),
        "period_ns": robot.tick_period_ns,
        "lockstep_allowed": safety.lockstep_allowed,
        "joints": [_joint(joint, robot.owner(joint.name), safety) for joint in robot.joints],
        "passive_joints": [
            _passive_joint(joint, safety.measured[joint.name]) for joint in robot.passive_joints
        ],
        "kinematics": {"root": tree.root, "links": [_link(link) for link in tree.links]},
        "parts": [_part(robot, part, safety) for part in robot.parts],
        "collision": compiled_shape(capsules, safety.self_collision),
        "workspace": compiled_workspace(safety.workspace),
        "base": compiled_base(safety.base, robot.base_joints),
        "protocol": safety.protocol.model_dump(exclude_none=True),
    }
    check_capacity(robot, config)
    check_possible(robot, profile, tree)
    check_home(robot, profile, tree, capsules)
    covered = {capsule.link for capsule in capsules.capsules}
    check_bare_links(robot, tree, covered, f"robot {robot.id}: {robot.capsules}")
    config["compiled_from"] = dict(source_digests(robot))
    config["content_sha256"] = ""
    text = json.dumps(config, indent=2, ensure_ascii=True, allow_nan=False) + "\n"
    return sealed(_NUMBER_LIST.sub(_on_one_line, text))


def sealed(text: str) -> str:
    """A gate file's text with the digest of all before it in ``content_sha256``, its last key.

    By it the gate notices at its start that somebody has changed the file since.
    """
    head, key, tail = text.rpartition('"content_sha256"')
    digest = hashlib.sha256(head.encode()).hexdigest()
    return head + key + re.sub('"[0-9a-f]*"', f'"{digest}"', tail)


def source_digests(robot: RobotManifest) -> dict[str, str]:
    """SHA-256 of each file that the gate file is made of, by its name in the robot's folder.

    Raises:
        ConfigError: if one cannot be read.
    """
    folder = robot_dir(robot.id)
    names = ("robot.yaml", robot.description, robot.capsules)
    try:
        return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}
    except OSError as error:
        raise ConfigError(
            f"robot {robot.id}: cannot read {error.filename} ({error.strerror})"
        ) from None


def _on_one_line(numbers: re.Match[str]) -> str:
    return "[" + " ".join(numbers[1].split()) + "]"


def _check_frames(
    robot: RobotManifest, safety: SafetyProfile, tree: DescriptionTree, shape: CapsuleFile
) -> None:
    named: list[tuple[str, tuple[str, ...]]] = [
        (f"end effector {tool.name!r}", (tool.tool_frame,)) for tool in robot.end_effectors
    ]
    named += [(f"{robot.capsules}: capsules", (capsule.link,)) for capsule in shape.capsules]
    for part, modes in safety.parts.items():
        for name in modes.names:
            frames = getattr(getattr(modes, name), "frames", ())
            named.append((f"part {part!r}: {name}: frames", frames))
    swept = {link.name for link in tree.links if is_swept(robot, tree, link)}
    own = [frame for frame in tree.frames if frame not in swept]
    for who, frames in named:
        for frame in frames:
            if frame not in own:
                wanted = "the link that carries this finger" if frame in swept else "a link"
                raise ConfigError(expected(f"robot {robot.id}: {who}", wanted, repr(frame), own))


def _link(link: Link) -> dict[str, Json]:
    return {
        "name": link.name,
        "parent": link.parent,
        "joint": link.joint,
        "kind": link.kind,
        "axis": link.axis,
        "translation": link.translation,
        "rotation_xyzw": link.rotation_xyzw,
    }


def _joint(joint: Joint, part: Part, safety: SafetyProfile) -> dict[str, Json]:
    measured = safety.measured[joint.name]
    velocity, acceleration, effort, source = profile_limits(joint, safety)
    # The gate judges by neither where a joint is told openings only.
    told_how_fast = not part.only_grips
    return {
        "name": joint.name,
        "part": part.name,
        "kind": joint.type,
        **_bounds(joint, measured),
        "velocity_limit": velocity if told_how_fast else None,
        "acceleration_limit": acceleration if told_how_fast else None,
        "effort_limit": effort,
        "jump_limit": measured.jump_per_tick,
        "standstill_velocity": measured.standstill_per_s,
        "contact_limit": measured.contact_limit,
        "encoder_step": measured.encoder_step,
        "dead_band": measured.dead_band_per_tick,
        "stop_lag": measured.stop_lag_s,
        "source": f"{source}; measured state: {measured.source}",
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
    """Position limits; zones, or none for a joint that turns without end, by declaration."""
    if joint.type == "continuous" and joint.bounded_by != "zones":
        return {"bounds": None}
    if not joint.has_bounds or measured.tolerance is None:
        return {"zones": {"frame": "odom"}}
    return {
        "bounds": {
            "lower": joint.lower,
            "upper": joint.upper,
            "tolerance": measured.tolerance,
        }
    }


def _part(robot: RobotManifest, part: Part, safety: SafetyProfile) -> dict[str, Json]:
    limits = safety.parts[part.name]
    tool = None if part.end_effector is None else robot.end_effector(part.end_effector)
    return {
        "name": part.name,
        "joints": list(part.joints),
        "tool_frame": None if tool is None else tool.tool_frame,
        "singularity_limit": limits.singularity_limit,
        "modes": {name: _mode(getattr(limits, name)) for name in limits.names},
        "transitions": limits.mode_changes,
        "source": f"robot.yaml, part {part.name}",
    }


def _mode(limits: BaseModel) -> dict[str, Json]:
    """One mode's block: the units in robot.yaml's field names are implied in the gate."""
    return {_gate_name(name): value for name, value in limits.model_dump().items()}


def _gate_name(field: str) -> str:
    if field in _GATE_NAMES:
        return _GATE_NAMES[field]
    for suffix in _UNIT_SUFFIXES:
        if field.endswith(suffix):
            return field.removesuffix(suffix)
    return field


MAX_SOURCE = 256
"""Bytes of a source that the gate keeps and cites."""
MAX_NAME = 64
_NAMES = ("name", "part", "link", "parent", "root", "tool_frame")
MAX_FRAMES = 4
"""Frames that a mode may be told in."""
MOST = {
    "joints": 32,
    "passive_joints": 16,
    "kinematics.links": 63,
    "parts": 8,
}


def check_capacity(robot: RobotManifest, config: dict[str, Json]) -> None:
    """Whether a compiled file fits into the gate.

    Raises:
        ConfigError: naming the place: a source or a name that the gate would cut, and so cite
            wrongly, a name that is none, a list that is too long.
    """
    _check(f"robot {robot.id}: gate file: ", "", "", config)


def _check(who: str, path: str, key: str, entry: Json) -> None:
    if isinstance(entry, dict):
        for name, value in entry.items():
            _check(who, f"{path}.{name}" if path else name, name, value)
    elif isinstance(entry, str):
        _check_text(f"{who}{path}", key, entry)
    elif isinstance(entry, list | tuple):
        most = MAX_FRAMES if key == "frames" else MOST.get(path, len(entry))
        if len(entry) > most:
            raise ConfigError(expected(f"{who}{path}", f"at most {most}", str(len(entry))))
        for index, value in enumerate(entry):
            _check(who, f"{path}[{index}]", "", value)


def _check_text(who: str, key: str, text: str) -> None:
    size = len(text.encode(errors="replace"))
    if not text.isprintable() and key == "source":
        raise ConfigError(expected(who, "text that can be printed, on one line", repr(text)))
    if key == "source" and size > MAX_SOURCE:
        raise ConfigError(expected(who, f"at most {MAX_SOURCE} bytes", f"{size}: {text!r}"))
    if key in _NAMES and not (0 < size <= MAX_NAME and text.isprintable() and text.strip()):
        wanted = f"a name of 1 to {MAX_NAME} bytes that can be printed"
        raise ConfigError(expected(who, wanted, repr(text)))
