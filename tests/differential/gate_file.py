"""The compiled gate file as plain numbers."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.equipment.kinematics import Kinematics

# shared/fairlead/modes.py.
MODES = (
    "joint_position",
    "joint_velocity",
    "joint_torque",
    "joint_trajectory",
    "cartesian_pose",
    "cartesian_delta",
    "cartesian_twist",
    "body_twist",
    "foot_placement",
    "gripper_binary",
    "gripper_position",
    "dex_hand_joint",
    "composite_mode",
)
WIDTHS = {4: 7, 5: 6, 6: 6, 7: 6, 9: 1, 10: 1, 12: 1}
JOINT_MODES = (0, 1, 11)
FRAMED_MODES = (4, 5, 6, 7)
NO_CHECKER = (2, 3, 8)
ROWS_MAX = 64

Block = dict[str, Any]
"""One mode of one part, as in the file."""


@dataclass(frozen=True)
class Joint:
    """One measured joint [rad or m, and per s]. Without bounds: -inf, inf, tolerance 0."""

    name: str
    lower: float
    upper: float
    tolerance: float
    jump_limit: float
    standstill: float
    source: str
    velocity_limit: float = math.nan
    effort_limit: float = math.nan
    encoder_step: float = 0.0
    turns: bool = False  # without end
    slides: bool = False

    def violation(self, position: float) -> float:
        """How far a position lies outside the bounds, 0 inside."""
        return max(self.lower - position, position - self.upper, 0.0)

    def is_outside(self, position: float) -> bool:
        """Outside the bounds and their tolerance."""
        return self.violation(position) > self.tolerance


@dataclass(frozen=True)
class Part:
    """joints: indices of the commanded joints. modes: the blocks by number. tool: its frame.
    transitions: pairs of modes, from and to. levers: by joint, how far the tool can be from its
    frame [m]."""

    name: str
    joints: tuple[int, ...]
    modes: dict[int, Block]
    tool: str | None
    transitions: frozenset[tuple[int, int]]
    levers: dict[int, float]


@dataclass(frozen=True)
class GateFile:
    """joints: commanded, in wire order. yaw_axis: where a base turns, x and y in base_link [m].

    turned_slides: the two joints of a base whose commands turn against its yaw.
    """

    joints: tuple[Joint, ...]
    passive: tuple[Joint, ...]
    parts: tuple[Part, ...]
    protocol: dict[str, Any]
    kinematics: Kinematics
    period_s: float
    yaw_axis: tuple[float, float] = (0.0, 0.0)
    turned_slides: frozenset[int] = frozenset()

    def width(self, mode: int) -> int:
        return len(self.joints) if mode in JOINT_MODES else WIDTHS[mode]


def read_gate_file(path: Path, urdf: Path) -> GateFile:
    """The file that the gate itself reads, and the robot's description."""
    data = json.loads(path.read_text())
    base = data["base"]
    turns = base and base["command_frame"] == "against_yaw"
    joints = tuple(_joint(entry) for entry in data["joints"])
    names = [joint.name for joint in joints]
    return GateFile(
        joints=joints,
        passive=tuple(_joint(entry) for entry in data["passive_joints"]),
        parts=tuple(_part(entry, names, data["kinematics"]["links"]) for entry in data["parts"]),
        protocol=data["protocol"],
        period_s=data["period_ns"] * 1e-9,
        kinematics=Kinematics(urdf, (*names, *(j["name"] for j in data["passive_joints"]))),
        yaw_axis=tuple(base["yaw_axis"]) if base else (0.0, 0.0),
        turned_slides=frozenset(map(names.index, base["joints"][:2] if turns else ())),
    )


def _joint(entry: dict[str, Any]) -> Joint:
    bounds = entry.get("bounds", {"lower": -math.inf, "upper": math.inf, "tolerance": 0.0})
    speed = entry.get("velocity_limit")  # null for a gripper's joint, absent for a passive one
    return Joint(
        name=entry["name"],
        lower=bounds["lower"],
        upper=bounds["upper"],
        tolerance=bounds["tolerance"],
        jump_limit=entry["jump_limit"],
        standstill=entry["standstill_velocity"],
        source=entry["source"],
        velocity_limit=math.nan if speed is None else speed,
        effort_limit=entry.get("effort_limit", math.nan),
        encoder_step=entry.get("encoder_step", 0.0),
        turns=entry.get("kind") == "continuous",
        slides=entry.get("kind") == "prismatic",
    )


def _part(entry: dict[str, Any], names: list[str], tree: list[dict[str, Any]]) -> Part:
    return Part(
        name=entry["name"],
        joints=tuple(names.index(name) for name in entry["joints"]),
        modes={MODES.index(name): dict(block) for name, block in entry["modes"].items()},
        tool=entry["tool_frame"],
        transitions=frozenset(
            (MODES.index(before), MODES.index(after)) for before, after in entry["transitions"]
        ),
        levers=_levers(tree, names, entry["tool_frame"]),
    )


def _levers(tree: list[dict[str, Any]], names: list[str], tool: str | None) -> dict[int, float]:
    links = {link["name"]: link for link in tree}
    found, lever, name = {}, 0.0, tool
    while name in links:
        link = links[name]
        if link["joint"] in names:
            found[names.index(link["joint"])] = lever
        lever += math.hypot(*link["translation"])
        name = link["parent"]
    return found
