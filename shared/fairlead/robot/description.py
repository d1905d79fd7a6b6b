"""The links of a robot's description (URDF) as the gate reads them: a plain tree.

Each link but the root hangs on its parent by a fixed placement, ``translation`` and then
``rotation_xyzw``, followed by the motion of one measured joint along or about ``axis``
(none where it is fixed). Parents come before their children.

What a description and a manifest both say of a joint has to agree. A description's limits are the
maker's. A manifest may be tighter; where it is wider one of the two is wrong, often by its unit.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from fairlead.errors import ConfigError, expected
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_DIGITS = 15  # of a quaternion's numbers: well below 1e-9 m, and the same on every machine
MOST_M = 100.0  # along an axis: what is more was meant in mm
_MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Link:
    """One link and how it hangs on its parent.

    Attributes:
        joint: name of the measured joint that moves it, None where it is fixed.
        kind: ``fixed``, ``revolute``, ``continuous`` or ``prismatic``.
        axis: unit vector in the link's own frame.
        translation: of the link's frame at joint position 0, in the parent's frame [m].
        rotation_xyzw: likewise, a unit quaternion.
    """

    name: str
    parent: str
    joint: str | None
    kind: str
    axis: Vector
    translation: Vector
    rotation_xyzw: Quaternion


@dataclass(frozen=True)
class DescriptionTree:
    """Every link of a description; ``links`` are all but the root, parents first."""

    root: str
    links: tuple[Link, ...]

    @property
    def frames(self) -> tuple[str, ...]:
        """The root and every link."""
        return (self.root, *(link.name for link in self.links))


def description_tree(robot: RobotManifest) -> DescriptionTree:
    """Read the robot's description.

    Raises:
        ConfigError: naming the file and the link or joint: no XML, more than one root, a
            root that is not the robot's base frame, a joint the robot does not measure or
            of another type than the manifest says, a name or a place in the tree given twice,
            a limit that robot.yaml exceeds, an arm's joint that moves nothing.
    """
    path = str(robot.description_path())
    try:
        document = ET.parse(path).getroot()  # noqa: S314 - a file of the robot's own folder
    except (OSError, ET.ParseError, LookupError, ValueError) as error:
        raise ConfigError(f"{path}: cannot be read as XML: {error}") from None
    joints = [_link(joint, robot, path) for joint in document.findall("joint")]
    _check_names(document, joints, path)
    children = {link.name for link in joints}
    roots = [name for name in _names(document, "link") if name not in children]
    if roots != [robot.base_frame]:
        raise ConfigError(expected(path, f"root link {robot.base_frame!r}", repr(roots)))
    links = _below(robot.base_frame, joints)
    if len(links) != len(joints):
        lost = children - {link.name for link in links}
        raise ConfigError(f"{path}: links that do not hang on the root: {sorted(lost)}")
    check_description_limits(robot, document, path)
    return DescriptionTree(robot.base_frame, links)


def _names(document: ET.Element, tag: str) -> list[str]:
    return [item.get("name", "") for item in document.findall(tag)]


def _check_names(document: ET.Element, links: list[Link], path: str) -> None:
    """Each link is declared once and hangs on one other; each joint is there once."""
    declared = _names(document, "link")
    for what, names in (("link", declared), ("joint", _names(document, "joint"))):
        for name, count in Counter(names).items():
            if count > 1:
                raise ConfigError(f"{path}: {what} {name!r} is declared {count} times")
    for name, count in Counter(link.name for link in links).items():
        if name not in declared:
            raise ConfigError(expected(f"{path}: child", "a link", repr(name), declared))
        if count > 1:
            raise ConfigError(f"{path}: link {name!r} hangs on {count} joints, expected one")


def _below(root: str, links: list[Link]) -> tuple[Link, ...]:
    """Depth first; each link hangs on one other, so none comes twice."""
    ordered: list[Link] = []
    waiting = [link for link in reversed(links) if link.parent == root]
    while waiting:
        ordered.append(waiting.pop())
        waiting += [link for link in reversed(links) if link.parent == ordered[-1].name]
    return tuple(ordered)


def _link(joint: ET.Element, robot: RobotManifest, path: str) -> Link:
    name, kind = joint.get("name", ""), joint.get("type", "")
    who = f"{path}: joint {name!r}"
    if kind not in (*_MOVING, "fixed"):
        raise ConfigError(expected(who, "a type", repr(kind), (*_MOVING, "fixed")))
    if kind != "fixed":
        _check_measured(name, kind, robot, who)
    parent, child = (joint.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise ConfigError(f"{who}: expected a parent and a child link")
    origin, axis = joint.find("origin"), joint.find("axis")
    return Link(
        name=child.get("link", ""),
        parent=parent.get("link", ""),
        joint=None if kind == "fixed" else name,
        kind=kind,
        axis=_axis(_vector(axis, "xyz", "1 0 0", who), kind, who),
        translation=_vector(origin, "xyz", "0 0 0", who),
        rotation_xyzw=_quaternion(_vector(origin, "rpy", "0 0 0", who)),
    )


def _check_measured(name: str, kind: str, robot: RobotManifest, who: str) -> None:
    if name not in robot.measured_joint_names:
        raise ConfigError(
            expected(who, "a joint the robot measures", repr(name), robot.measured_joint_names)
        )
    declared = robot.joint(name).type
    if (kind == "prismatic") != (declared == "prismatic"):
        raise ConfigError(expected(who, f"the manifest's type {declared!r}", repr(kind)))


def _vector(element: ET.Element | None, name: str, default: str, who: str) -> Vector:
    text = default if element is None else element.get(name, default)
    try:
        x, y, z = (float(word) for word in text.split())
    except ValueError:
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        raise ConfigError(expected(f"{who}: {name}", "three numbers", repr(text)))
    if name == "xyz" and max(abs(x), abs(y), abs(z)) > MOST_M:
        raise ConfigError(expected(f"{who}: {name}", f"metres, at most {MOST_M:g}", repr(text)))
    return x, y, z


def _axis(axis: Vector, kind: str, who: str) -> Vector:
    """The unit vector; exporters write 0 0 0 for a joint that does not move."""
    norm = math.hypot(*axis)
    if kind == "fixed" and norm == 0.0:
        return 1.0, 0.0, 0.0
    if not norm > 0.0:
        raise ConfigError(expected(f"{who}: axis", "a direction", repr(axis)))
    x, y, z = (_rounded(value / norm) for value in axis)
    return x, y, z


def _quaternion(rpy: Vector) -> Quaternion:
    """Rotation about the fixed axes x, then y, then z [rad], as xyzw with w >= 0."""
    (sr, sp, sy), (cr, cp, cy) = ([f(a / 2) for a in rpy] for f in (math.sin, math.cos))
    x, y, z, w = (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    sign = -1.0 if w < 0.0 else 1.0
    return _rounded(sign * x), _rounded(sign * y), _rounded(sign * z), _rounded(sign * w)


def _rounded(value: float) -> float:
    return round(value, _DIGITS) + 0.0  # never -0.0


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
        for name, described_as, told in _pairs(joint, entry.find("limit"), who):
            if (told < described_as) if name == "lower" else (told > described_as):
                raise ConfigError(
                    f"{who}: expected {name} in robot.yaml within the description's, "
                    f"{described_as:g}, got {told:g}"
                )


def _pairs(joint: Joint, limit: ET.Element | None, who: str) -> Iterator[tuple[str, float, float]]:
    """Name, the description's number and the manifest's."""
    if limit is None:
        return
    told = {"velocity": joint.velocity_limit, "effort": joint.effort_limit}
    if joint.has_bounds:
        told |= {"lower": joint.lower, "upper": joint.upper}
    for name, value in told.items():
        text = limit.get(name)
        if text is not None:
            yield name, _number(text, f"{who}: limit {name}"), value


def _number(text: str, who: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(expected(who, "a number", repr(text)))
    return value
