"""The links of a robot's description (URDF) as the gate reads them: a plain tree.

Each link but the root hangs on its parent by a fixed placement, ``translation`` and then
``rotation_xyzw``, followed by the motion of one measured joint along or about ``axis``
(none where it is fixed). Parents come before their children.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass
from functools import cached_property

from fairlead.errors import ConfigError, expected
from fairlead.robot.description_limits import check_description_limits, check_limit, number
from fairlead.robot.manifest import RobotManifest

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_DIGITS = 15  # of a quaternion's numbers: well below 1e-9 m, and the same on every machine
MOST_M = 100.0  # along an axis: what is more was meant in mm
_MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Mimic:
    """How a link moves that a linkage drives: position = multiplier * ``joint``'s + offset.

    Attributes:
        name: of its own joint, which nothing measures.
        joint: a measured joint.
        kind: of its own motion: ``revolute`` or ``prismatic``.
    """

    name: str
    joint: str
    multiplier: float
    offset: float
    kind: str


@dataclass(frozen=True)
class Link:
    """One link and how it hangs on its parent.

    Attributes:
        joint: name of the measured joint that moves it, None where it is fixed.
        kind: ``fixed``, ``revolute``, ``continuous`` or ``prismatic``.
        mimic: of a joint that nothing measures and that mimics another; for the gate, whose
            capsules cover wherever such a link can be, it is fixed.
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
    mimic: Mimic | None = None


@dataclass(frozen=True)
class DescriptionTree:
    """Every link of a description; ``links`` are all but the root, parents first."""

    root: str
    links: tuple[Link, ...]

    @property
    def frames(self) -> tuple[str, ...]:
        """The root and every link."""
        return (self.root, *(link.name for link in self.links))

    @cached_property
    def coupled(self) -> frozenset[str]:
        """Links that mimic joints move, and all that these carry."""
        found: set[str] = set()
        for link in self.links:
            if link.mimic is not None or link.parent in found:
                found.add(link.name)
        return frozenset(found)


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
    tree = DescriptionTree(robot.base_frame, links)
    _check_coupled(robot, tree, path)
    return tree


def _check_coupled(robot: RobotManifest, tree: DescriptionTree, path: str) -> None:
    """What a mimic joint carries has no place of its own in the gate."""
    moving = [link.joint for link in tree.links if link.joint]
    for link in tree.links:
        if link.mimic is not None and link.mimic.joint not in moving:
            who = f"{path}: what moves link {link.name!r} mimics"
            raise ConfigError(expected(who, "a joint that moves a link", link.mimic.joint, moving))
    named = {
        f"end effector {tool.name!r}: tool_frame": tool.tool_frame for tool in robot.end_effectors
    }
    named |= {f"joint {link.joint!r}: child": link.name for link in tree.links if link.joint}
    for what, name in named.items():
        if name in tree.coupled:
            raise ConfigError(
                f"{path}: {what}: expected no link that a mimic joint moves, got {name!r}"
            )


def _names(document: ET.Element, tag: str) -> list[str]:
    return [item.get("name", "") for item in document.findall(tag)]


def _check_names(document: ET.Element, links: list[Link], path: str) -> None:
    """Each link is declared once and hangs on one other; each joint is there once."""
    declared = _names(document, "link")
    for what, names in (("link", declared), ("joint", _names(document, "joint"))):
        for name, count in Counter(names).items():
            if count > 1:
                raise ConfigError(f"{path}: {what} {name!r} is declared {count} times")
    for link in links:
        if link.parent not in declared:
            who = f"{path}: parent of link {link.name!r}"
            raise ConfigError(expected(who, "a link", repr(link.parent), declared))
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
    check_limit(joint, who)
    mimic = None if kind == "fixed" else _mimic(joint, kind, robot, who)
    if kind != "fixed" and mimic is None:
        _check_measured(name, kind, robot, who)
    moves = kind != "fixed" and mimic is None
    parent, child = (joint.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise ConfigError(f"{who}: expected a parent and a child link")
    origin, axis = joint.find("origin"), joint.find("axis")
    return Link(
        name=child.get("link", ""),
        parent=parent.get("link", ""),
        joint=name if moves else None,
        kind=kind if moves else "fixed",
        axis=_axis(_vector(axis, "xyz", "1 0 0", who), kind, who),
        translation=_vector(origin, "xyz", "0 0 0", who),
        rotation_xyzw=_quaternion(_vector(origin, "rpy", "0 0 0", who)),
        mimic=mimic,
    )


def _mimic(joint: ET.Element, kind: str, robot: RobotManifest, who: str) -> Mimic | None:
    """What an unmeasured joint mimics; one that is measured needs no telling."""
    entry = joint.find("mimic")
    if entry is None or joint.get("name", "") in robot.measured_joint_names:
        return None
    if kind == "continuous":
        raise ConfigError(expected(f"{who}: type of a mimic joint", "revolute or prismatic", kind))
    source, valid = entry.get("joint", ""), robot.measured_joint_names
    if source not in valid:
        raise ConfigError(
            expected(f"{who}: mimic", "a joint the robot measures", repr(source), valid)
        )
    multiplier, offset = (
        number(entry.get(name, default), f"{who}: mimic: {name}")
        for name, default in (("multiplier", "1"), ("offset", "0"))
    )
    return Mimic(joint.get("name", ""), source, multiplier, offset, kind)


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
