"""Deltas that leave some of a tool's axes free: what the arm does with those, it is told.

An arm of five joints cannot move its tool without turning it. A delta that says the turn is to be
zero then costs a part of the shift; one that leaves it free gets the turn that comes with the
least motion of the arm's joints. The row that the gate judges has all six numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import FloatArray, link_poses
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.robot.tool_chain import ToolChain

DAMPING = 0.02
"""Bounds the joints near a singular pose [m or rad], as the gate's prediction does."""


class FreeAxes:
    """One arm's kinematics, for deltas that leave axes of its tool free.

    Args:
        frame: along whose axes the deltas are.
        told: which of x y z rx ry rz are not free.
    """

    def __init__(self, robot: RobotManifest, part: Part, frame: str, told: Sequence[int]) -> None:
        self._robot, self._frame = robot, frame
        self._told = sorted(told)
        self._joints = part.joints
        self._tree = description_tree(robot)
        tool = robot.end_effector(part.end_effector or "").tool_frame
        self._chain = ToolChain(self._tree, tool)

    def completed(self, rows: FloatArray, positions: FloatArray) -> FloatArray:
        """The rows with the free axes filled in.

        Args:
            rows: ``[H, 6]`` [m, rad], one a control period.
            positions: of all measured joints where the rows begin, in wire order [rad or m].
        """
        names = self._robot.measured_joint_names
        at = dict(zip(names, positions.tolist(), strict=True))
        poses = link_poses(self._tree, {name: np.array([value]) for name, value in at.items()})
        to_frame = np.kron(np.eye(2), poses[self._frame].rotation[0].T)
        found = rows.copy()
        for row in found:
            jacobian = to_frame @ self._chain.jacobian(at, self._joints)
            told = jacobian[self._told]
            gram = told @ told.T + DAMPING**2 * np.eye(len(told))
            step = told.T @ np.linalg.solve(gram, row[self._told])
            moved = jacobian @ step
            moved[self._told] = row[self._told]
            row[:] = moved
            for name, moved_by in zip(self._joints, step, strict=True):
                at[name] += float(moved_by)
        return found
