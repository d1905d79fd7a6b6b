"""How a backend tells a part's command ranges: those of robot.yaml's limits."""

from __future__ import annotations

from fairlead.messages import HalPart, ModeRange, pack_floats
from fairlead.robot.command_ranges import command_range
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part


def describe_part(robot: RobotManifest, part: Part, profile: str) -> HalPart:
    """The part with the limits of a safety profile as its command ranges."""
    limits = robot.profile(profile).parts[part.name]
    ranges = []
    for mode in part.control_modes:
        lower, upper = command_range(robot, part, mode, limits)
        ranges.append(ModeRange(mode=mode, lower=pack_floats(lower), upper=pack_floats(upper)))
    return HalPart(
        name=part.name,
        simulator_part=part.simulator_part,
        joints=part.joints,
        ranges=tuple(ranges),
    )
