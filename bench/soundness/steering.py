"""How well an arm's joints steer its tool."""

from __future__ import annotations

import numpy as np

from bench.equipment.kinematics import Kinematics
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest

CARTESIAN = {
    ControlMode.CARTESIAN_POSE,
    ControlMode.CARTESIAN_DELTA,
    ControlMode.CARTESIAN_TWIST,
}


class Steering:
    """The parts of a robot with cartesian modes and a declared `singularity_limit`."""

    def __init__(self, robot: RobotManifest) -> None:
        names = robot.measured_joint_names
        self._kinematics = Kinematics(robot.description_path(), names)
        self._root = robot.base_frame
        self._parts = []
        for part in robot.parts:
            limit = robot.profile("sim").parts[part.name].singularity_limit
            if limit is not None and part.end_effector and CARTESIAN & set(part.control_modes):
                tool = robot.end_effector(part.end_effector).tool_frame
                own = [names.index(name) for name in part.joints]
                self._parts.append((own, tool, limit))

    def is_singular(self, q: FloatArray) -> bool:
        """Whether the smallest singular value of a tool's Jacobian is below its limit."""
        return any(self._least(q, own, tool) < limit for own, tool, limit in self._parts)

    def _least(self, q: FloatArray, own: list[int], tool: str) -> float:
        columns = []
        for joint in own:
            one = np.zeros(len(q))
            one[joint] = 1.0
            columns.append(self._kinematics.twist(q, one, tool, self._root))
        return float(np.linalg.svd(np.stack(columns, axis=1), compute_uv=False)[-1])
