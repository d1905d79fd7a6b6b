"""How far and how fast a robot's joints can move its tools, by its description."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fairlead.robot.description import DescriptionTree, Link
from fairlead.robot.joint import Joint
from fairlead.robot.link_poses import FloatArray, link_poses, random_positions
from fairlead.robot.manifest import RobotManifest

POSTURES = 1000
DIRECTIONS = 200
"""Of the speed, spread over a sphere: the fastest is within 2 % of one of them."""


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
        return sum(self.span(link) for link in self.chain(frame))

    @property
    def farthest_m(self) -> float:
        """Farthest that any frame can be from the root's origin [m]."""
        return max((self.of(frame) for frame in self.tree.frames), default=0.0)

    @property
    def longest_link_m(self) -> float:
        """Farthest that a link can be from the one it hangs on [m]."""
        return max((self.span(link) for link in self.tree.links), default=0.0)

    def tool_speed(
        self, frame: str, joints: Sequence[str], speeds: Mapping[str, float]
    ) -> ToolSpeed:
        """Fastest that these joints, each at its speed, can move a frame in half of all postures.

        The rest, with the arm stretched out, is faster (a Panda by up to 40 %): no limit is meant
        to be exceeded there only.
        """
        poses = link_poses(self.tree, random_positions(self.robot, self.tree, POSTURES))
        tool = poses[frame].translation
        linear, angular = [np.zeros((POSTURES, 3))], [np.zeros((POSTURES, 3))]
        for link in self.chain(frame):
            if link.joint is not None and link.joint in joints:
                moves = poses[link.name].rotation @ np.array(link.axis) * speeds[link.joint]
                if link.kind == "prismatic":
                    linear.append(moves)
                else:
                    angular.append(moves)
                    linear.append(np.cross(moves, tool - poses[link.name].translation))
        return ToolSpeed(_median_of_fastest(linear), _median_of_fastest(angular))

    def span(self, link: Link) -> float:
        """Farthest that a link's origin can be from its parent's [m]."""
        span = math.hypot(*link.translation)
        if link.kind == "prismatic":
            span += _stroke(self.robot.joint(str(link.joint)))
        return span


def _stroke(joint: Joint) -> float:
    return max(abs(joint.lower), abs(joint.upper)) if joint.has_bounds else 0.0


def _median_of_fastest(moves: Sequence[FloatArray]) -> float:
    """Of sums of these, each ``[n, 3]`` or its opposite, the longest; of n postures the median.

    The longest is as long as its shadow on its own direction, where each adds its shadow's size.
    """
    turn = np.arange(DIRECTIONS) * math.pi * (3.0 - math.sqrt(5.0))  # the golden angle
    up = 1.0 - 2.0 * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    across = np.sqrt(1.0 - up * up)
    directions = np.stack([across * np.cos(turn), across * np.sin(turn), up])
    shadows = sum(np.abs(one @ directions) for one in moves)
    return float(np.median(np.max(shadows, axis=1)))
