"""What a robot's description (URDF) and its manifest both say of a joint has to agree.

A description's limits are the maker's. A manifest may be tighter; where it is wider one of the two
is wrong, often by its unit.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator

from fairlead.errors import ConfigError, expected
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest

_PLACED_BY_ITSELF = ("base", "gripper")
"""Roles of joints that need not be in the tree: zones bound a base, a gripper's is an opening."""


def check_description_limits(robot: RobotManifest, document: ET.Element, path: str) -> None:
    """Compare the joints of ``robot`` with those of its description.

    Args:
        document: the root element of the description.
        path: the file, as errors call it.

    Raises:
        ConfigError: a joint of an arm, a hand, a head or a torso that moves no link; a joint that
            is commanded and mimics another; a limit that the manifest exceeds.
    """
    described = {joint.get("name", ""): joint for joint in document.findall("joint")}
    for joint in (*robot.joints, *robot.passive_joints):
        who = f"{path}: joint {joint.name!r}"
        entry = described.get(joint.name)
        moves = entry is not None and entry.get("type") != "fixed"
        if not moves and joint.role not in _PLACED_BY_ITSELF:
            got = "none" if entry is None else "a fixed one"
            raise ConfigError(
                expected(who, f"one that moves a link, as its role {joint.role}", got)
            )
        if entry is None:
            continue
        if joint.type == "continuous" and entry.get("type") != "continuous":
            raise ConfigError(
                expected(f"{who}: type", "continuous, as in robot.yaml", repr(entry.get("type")))
            )
        if entry.find("mimic") is not None and joint in robot.joints:
            raise ConfigError(f"{who}: robot.yaml commands it, and it mimics another joint")
        for name, described_as, told in _pairs(joint, entry, who):
            if (told < described_as) if name == "lower" else (told > described_as):
                raise ConfigError(
                    f"{who}: expected {name} in robot.yaml within the description's, "
                    f"{described_as:g}, got {told:g}"
                )


def check_limit(joint: ET.Element, who: str) -> None:
    """What every reader of the format asks for: a sliding or turning joint has a ``<limit>``.

    Raises:
        ConfigError: it has none, or one without a number for effort or velocity.
    """
    limit = joint.find("limit")
    if limit is None:
        if joint.get("type") in ("revolute", "prismatic"):
            what = '<limit lower="..." upper="..." effort="..." velocity="..."/>'
            raise ConfigError(expected(who, what, "none"))
        return
    for name in ("effort", "velocity"):
        text = limit.get(name)
        if text is None:
            raise ConfigError(expected(f"{who}: limit {name}", "a number", "none"))
        number(text, f"{who}: limit {name}")


def _pairs(joint: Joint, entry: ET.Element, who: str) -> Iterator[tuple[str, float, float]]:
    """Name, the description's number and the manifest's; an end that is not given is 0 there."""
    limit, ends = entry.find("limit"), {"lower": "0", "upper": "0"}
    if limit is None:
        return
    told = {"velocity": joint.velocity_limit, "effort": joint.effort_limit}
    if joint.has_bounds:
        told |= {"lower": joint.lower, "upper": joint.upper}
    for name, value in told.items():
        text = limit.get(name)
        if text is None and entry.get("type") != "continuous":
            text = ends.get(name)
        if text is not None:
            yield name, number(text, f"{who}: limit {name}"), value


def number(text: str, who: str) -> float:
    """A finite number of the description; raises `ConfigError` for anything else."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(expected(who, "a number", repr(text)))
    return value
