"""How far and how fast a robot's joints can move its tools, by its description: upper bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fairlead.robot.description_tree import DescriptionTree, Link
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest


@dataclass(frozen=True)
class ToolSpeed:
    """What all joints of a part can do to its tool at once [m/s, rad/s]."""

    linear_m_s: float
    angular_rad_s: float


@dataclass(frozen=True)
class Reach:
    """Distances and speeds along the chains of a description: bounds, not what is attained."""

    robot: RobotManifest
    tree: DescriptionTree

    def chain(self, frame: str) -> Sequence[Link]:
        """The links from the root to a frame."""
        parents = {link.name: link for link in self.tree.links}
        found = []
        while frame in parents:
            found.append(parents[frame])
            frame = parents[frame].parent
        return found[::-1]

    def of(self, frame: str) -> float:
        """Farthest that a frame can be from the root's origin [m]."""
        return sum(self._span(link) for link in self.chain(frame))

    @property
    def farthest_m(self) -> float:
        """Farthest that any frame can be from the root's origin [m]."""
        return max((self.of(frame) for frame in self.tree.frames), default=0.0)

    @property
    def longest_link_m(self) -> float:
        """Farthest that a link can be from the one it hangs on [m]."""
        return max((self._span(link) for link in self.tree.links), default=0.0)

    def tool_speed(
        self, frame: str, joints: Sequence[str], speeds: Mapping[str, float]
    ) -> ToolSpeed:
        """Fastest that these joints, each at its speed [rad/s or m/s], can move a frame."""
        linear = angular = 0.0
        chain = self.chain(frame)
        for place, link in enumerate(chain):
            if link.joint in joints:
                speed = speeds[str(link.joint)]
                if link.kind == "prismatic":
                    linear += speed
                else:
                    angular += speed
                    linear += speed * sum(self._span(one) for one in chain[place + 1 :])
        return ToolSpeed(linear, angular)

    def _span(self, link: Link) -> float:
        """Farthest that a link's origin can be from its parent's [m]."""
        span = math.hypot(*link.translation)
        if link.kind == "prismatic":
            span += _stroke(self.robot.joint(str(link.joint)))
        return span


def _stroke(joint: Joint) -> float:
    return max(abs(joint.lower), abs(joint.upper)) if joint.has_bounds else 0.0
