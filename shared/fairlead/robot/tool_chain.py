"""One tool of a robot: where it is, and how each joint between it and the root moves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fairlead.robot.description import DescriptionTree
from fairlead.robot.link_poses import FloatArray, motion, placement


class ToolChain:
    """The links from the root to one frame.

    Args:
        tool: a link of the description that no mimic joint moves.
    """

    def __init__(self, tree: DescriptionTree, tool: str) -> None:
        parents, chain = {link.name: link for link in tree.links}, []
        while tool in parents:
            chain.append(parents[tool])
            tool = chain[-1].parent
        self._chain = [(link, *placement(link)) for link in reversed(chain)]

    def pose(self, at: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Position [m] and rotation matrix in the root, by joint positions [rad or m]."""
        turn, place = np.eye(3), np.zeros(3)
        for link, rotation, translation in self._chain:
            place, turn = place + turn @ translation, turn @ rotation
            if link.joint is not None:
                turned, shifted = motion(link, np.array([at[link.joint]]))
                place, turn = place + turn @ shifted[0], turn @ turned[0]
        return place, turn

    def jacobian(self, at: Mapping[str, float], joints: Sequence[str]) -> FloatArray:
        """``[6, len(joints)]``: the tool origin's motion along the root's axes, linear first."""
        turn, place = np.eye(3), np.zeros(3)
        moving: list[tuple[str, bool, FloatArray, FloatArray]] = []
        for link, rotation, translation in self._chain:
            place, turn = place + turn @ translation, turn @ rotation
            if link.joint is not None:
                axis = turn @ np.array(link.axis)
                moving.append((link.joint, link.kind == "prismatic", axis, place))
                turned, shifted = motion(link, np.array([at[link.joint]]))
                place, turn = place + turn @ shifted[0], turn @ turned[0]
        jacobian = np.zeros((6, len(joints)))
        for name, slides, axis, origin in moving:
            if name in joints:
                column = jacobian[:, list(joints).index(name)]
                column[:3] = axis if slides else np.cross(axis, place - origin)
                column[3:] = 0.0 if slides else axis
        return jacobian
