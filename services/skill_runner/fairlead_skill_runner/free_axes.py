"""Deltas that leave some of a tool's axes free: what the arm does with those, it is told.

An arm of five joints cannot move its tool without turning it. A delta that says the turn is to be
zero then costs a part of the shift; one that leaves it free gets the turn that comes with the
least motion of the arm's joints. The row that the gate judges has all six numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import link_poses, motion, placement
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.routes import Route

DAMPING = 0.02
"""Bounds the joints near a singular pose [m or rad], as the gate's prediction does."""


class FreeAxes:
    """One arm's kinematics, for one route that leaves axes of its tool free."""

    def __init__(self, robot: RobotManifest, route: Route) -> None:
        self._robot, self._frame = robot, route.frame_id
        self._told = sorted(route.columns)
        part = robot.parts[route.part]
        self._joints = {name: index for index, name in enumerate(part.joints)}
        self._tree = description_tree(robot)
        parents = {link.name: link for link in self._tree.links}
        name, chain = robot.end_effector(part.end_effector or "").tool_frame, []
        while name in parents:
            chain.append(parents[name])
            name = chain[-1].parent
        self._chain = [(link, *placement(link)) for link in reversed(chain)]

    def completed(self, rows: FloatArray, positions: FloatArray) -> FloatArray:
        """The rows with the free axes filled in.

        Args:
            rows: ``[H, 6]`` [m, rad], one a control period.
            positions: of all measured joints where the rows begin, in wire order [rad or m].
        """
        names = self._robot.measured_joint_names
        at = dict(zip(names, positions, strict=True))
        poses = link_poses(self._tree, {name: np.array([value]) for name, value in at.items()})
        to_frame = np.kron(np.eye(2), poses[self._frame].rotation[0].T)
        found = rows.copy()
        for row in found:
            jacobian = to_frame @ self._jacobian(at)
            told = jacobian[self._told]
            gram = told @ told.T + DAMPING**2 * np.eye(len(told))
            step = told.T @ np.linalg.solve(gram, row[self._told])
            moved = jacobian @ step
            moved[self._told] = row[self._told]
            row[:] = moved
            for name, index in self._joints.items():
                at[name] += step[index]
        return found

    def _jacobian(self, at: dict[str, float]) -> FloatArray:
        """Of the tool's origin along the root's axes: ``[6, joints of the part]``."""
        turn, place = np.eye(3), np.zeros(3)
        moving: list[tuple[str, bool, FloatArray, FloatArray]] = []
        for link, rotation, translation in self._chain:
            place, turn = place + turn @ translation, turn @ rotation
            if link.joint is not None:
                axis = turn @ np.array(link.axis)
                moving.append((link.joint, link.kind == "prismatic", axis, place))
                turned, shifted = motion(link, np.array([at[link.joint]]))
                place, turn = place + turn @ shifted[0], turn @ turned[0]
        jacobian = np.zeros((6, len(self._joints)))
        for name, slides, axis, origin in moving:
            if name in self._joints:
                column = jacobian[:, self._joints[name]]
                column[:3] = axis if slides else np.cross(axis, place - origin)
                column[3:] = 0.0 if slides else axis
        return jacobian


def free_axes(routes: Sequence[Route], robot: RobotManifest) -> dict[int, FreeAxes]:
    """By the part's number, for each route that leaves axes free."""
    return {route.part: FreeAxes(robot, route) for route in routes if route.leaves_axes_free}
