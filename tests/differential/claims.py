"""What a claim may tighten, and the robot's limits with a claim's own in them.

"A claim's limits may be tighter than the robot's, never looser; a mode that the claim does not
tighten keeps the robot's limits" (docs/safety.md, Claims).
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from fairlead.messages import LimitOverride
from tests.differential.gate_file import MODES, Block, GateFile

SIDES = tuple(f"{end}_{axis}" for end in ("lower", "upper") for axis in "xyz")


@dataclass(frozen=True)
class Room:
    """From where to where a limit may move; where one end is the opposite limit, or 0 of a norm or
    a step, that end itself is out."""

    lowest: float
    highest: float
    without_lowest: bool
    without_highest: bool = False


def tightenable(file: GateFile, part: int, mode: int) -> dict[str, Room]:
    """Every limit of that mode that a claim can name."""
    block = file.parts[part].modes[mode]
    found = {
        name: Room(0.0, float(min(value) if isinstance(value, list) else value), True)
        for name, value in block.items()
        if name.endswith("_limit") and name != "slip_limit"
    }
    joints = [file.joints[index] for index in file.parts[part].joints]
    if MODES[mode] == "joint_velocity":
        most = min(joint.velocity_limit for joint in joints)
        found["velocity_limit"] = Room(0.0, block.get("velocity_limit", most), True)
    if MODES[mode] == "cartesian_pose":
        for name in SIDES:
            axis = "xyz".index(name[-1])
            found[name] = _end(name, block["lower"][axis], block["upper"][axis])
    if MODES[mode] in ("gripper_position", "composite_mode"):
        lower, upper = block.get("lower", -1.0), block.get("upper", 1.0)
        found |= {name: _end(name, lower, upper) for name in ("lower", "upper")}
    return found


def _end(name: str, lower: float, upper: float) -> Room:
    is_lower = name.startswith("lower")
    return Room(lower, upper, without_lowest=not is_lower, without_highest=is_lower)


def drawn_override(file: GateFile, part: int, mode: int, rng: np.random.Generator) -> LimitOverride:
    """One limit of that mode, somewhere in its room."""
    rooms = tightenable(file, part, mode)
    name = str(rng.choice(sorted(rooms)))
    room = rooms[name]
    span = room.highest - room.lowest
    share = float(rng.choice([0.0, 0.99, rng.uniform(0.0, 0.9), rng.uniform(0.0, 0.3)]))
    value = room.lowest + share * span if "lower" in name else room.highest - share * span
    value = min(max(value, room.lowest), room.highest)
    return LimitOverride(part=file.parts[part].name, mode=mode, name=name, value=value)


def tightened(file: GateFile, overrides: Iterable[LimitOverride]) -> GateFile:
    """The file with a claim's own limits in place of the robot's: only tighter ones, please."""
    parts = list(file.parts)
    for override in overrides:
        index = [part.name for part in parts].index(override.part)
        modes = copy.deepcopy(parts[index].modes)
        _replace(modes[override.mode], override.name, override.value)
        parts[index] = replace(parts[index], modes=modes)
    return replace(file, parts=tuple(parts))


def _replace(block: Block, name: str, value: float) -> None:
    if name in SIDES:
        block[name[:-2]]["xyz".index(name[-1])] = value
    elif isinstance(block.get(name), list):
        block[name] = [value] * len(block[name])
    else:
        block[name] = value


def is_tighter(room: Room, value: float) -> bool:
    """Whether a claim may ask for that value."""
    is_out = (room.without_lowest and value == room.lowest) or (
        room.without_highest and value == room.highest
    )
    return room.lowest <= value <= room.highest and not is_out
