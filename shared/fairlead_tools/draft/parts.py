"""Which joints are commanded together: arms, what grips at their ends, and their tools."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from fairlead_tools.draft.joints import DraftJoint

_FINGERS = r"finger|jaw|knuckle|claw|thumb|index_|middle_|ring_|pinky"
_FINGER, _GRIPS = re.compile(_FINGERS, re.I), re.compile(rf"grip|pinch|{_FINGERS}", re.I)
_NONE = 1e-9
_JOINTS = 5
"""An arm of fewer cannot move its tool in each direction wherever it is."""
_TOOLS = (
    re.compile(r"tcp|tool|eef|end_?effector|(^|_)ee(_|$)", re.I),
    re.compile(r"grip|pinch", re.I),
    re.compile(r"attachment|flange", re.I),
)


@dataclass(frozen=True)
class DraftPart:
    """Joints that are commanded together, and the link that is their tool."""

    name: str
    role: str
    joints: tuple[DraftJoint, ...]
    tool: str

    @property
    def opens(self) -> bool:
        """Whether it is a gripper of one joint: it is told where that goes."""
        return self.role == "gripper" and len(self.joints) == 1 and self.joints[0].lower is not None

    @property
    def moves_tool(self) -> bool:
        """Whether its tool can be told where to move, in each direction."""
        return self.role == "arm" and len(self.joints) >= _JOINTS


def grips(joint: DraftJoint) -> bool:
    """Whether a joint is a gripper's, by its name, or its link's that is a finger's."""
    return bool(_GRIPS.search(joint.name) or _FINGER.search(joint.child))


def with_openings(joints: Sequence[DraftJoint]) -> list[DraftJoint]:
    """Two fingers that slide away from each other become one opening; both are measured only."""
    sliding: dict[str, list[DraftJoint]] = {}
    for one in joints:
        if grips(one) and one.commanded and one.type == "prismatic" and one.model_joints:
            sliding.setdefault(one.parent, []).append(one)
    pairs = [two for two in sliding.values() if len(two) == 2 and _are_mirrored(*two)]
    fingers = [one for pair in pairs for one in pair]
    found = [replace(one, commanded=False) if one in fingers else one for one in joints]
    for number, pair in enumerate(pairs, start=1):
        name = "gripper" if len(pairs) == 1 else f"gripper_{number}"
        while name in [one.name for one in found]:
            name += "_opening"
        first, second = sorted(pair, key=lambda one: -(one.upper or 0.0))
        opening = replace(
            first, name=name, lower=0.0, upper=2.0 * first.span, velocity=2.0 * first.velocity,
            acceleration=2.0 * first.acceleration, sag=first.sag + second.sag,
            model_joints=(*first.model_joints, *second.model_joints),
        )  # fmt: skip
        found.append(opening)
    return found


def _are_mirrored(one: DraftJoint, other: DraftJoint) -> bool:
    first, second = sorted((one, other), key=lambda joint: -(joint.upper or 0.0))
    ends = (first.lower or 0.0, second.upper or 0.0)
    return max(map(abs, ends)) < _NONE and abs(first.span - second.span) < _NONE


def draft_parts(urdf: ET.Element, joints: Sequence[DraftJoint]) -> list[DraftPart]:
    """Arms in the order of the file, each followed by what grips at its end."""
    by_link = {one.find("child").get("link", ""): one for one in urdf.findall("joint")}  # type: ignore[union-attr]
    commanded = [one for one in joints if one.commanded]
    arm_joints = {one.child: one for one in commanded if not grips(one)}
    arms: dict[str, list[DraftJoint]] = {}
    for one in arm_joints.values():
        first = [link for link in _above(one.child, by_link) if link in arm_joints][-1]
        arms.setdefault(first, []).append(one)
    parts = []
    for number, (first, own) in enumerate(arms.items(), start=1):
        ending = f"_{number}" if len(arms) > 1 else ""
        last = max(own, key=lambda one: len(_above(one.child, by_link)))
        tool = _tool(urdf, last.child, by_link)
        parts.append(DraftPart(f"arm{ending}", "arm", tuple(own), tool))
        gripping = [one for one in commanded if grips(one) and first in _above(one.child, by_link)]
        if gripping:
            parts.append(DraftPart(f"gripper{ending}", "gripper", tuple(gripping), tool))
    held = {one.name for part in parts for one in part.joints}
    rest = tuple(one for one in commanded if one.name not in held)
    if rest:
        tool = _tool(urdf, rest[-1].child, by_link)
        parts.append(DraftPart("gripper_alone" if parts else "gripper", "gripper", rest, tool))
    return parts


def _above(link: str, by_link: Mapping[str, ET.Element]) -> list[str]:
    """The link and those it hangs on, itself first."""
    found = [link]
    while found[-1] in by_link and len(found) <= len(by_link):
        parent = by_link[found[-1]].find("parent")
        found.append("" if parent is None else parent.get("link", ""))
    return found


def _tool(urdf: ET.Element, carrier: str, by_link: Mapping[str, ET.Element]) -> str:
    """What is fixed to an arm's last link and called like a tool, or is the only end; else that."""
    fixed = []
    for link in (one.get("name", "") for one in urdf.findall("link")):
        above = _above(link, by_link)
        if link != carrier and carrier in above:
            way = above[: above.index(carrier)]
            if all(by_link[one].get("type") == "fixed" for one in way):
                fixed.append(link)
    named = (link for pattern in _TOOLS for link in fixed if pattern.search(link))
    parents = {one.get("link") for one in urdf.findall("joint/parent")}
    ends = [link for link in fixed if link not in parents]
    return next(named, ends[0] if len(ends) == 1 else carrier)
