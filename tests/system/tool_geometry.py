"""Where a robot's tool is, by its description alone."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from tests.system.mode_robot import Story


class ToolGeometry:
    """Forward kinematics of the description (URDF) for measured joints."""

    def __init__(self, robot: RobotManifest) -> None:
        self._names = robot.measured_joint_names
        self._model = pin.buildModelFromUrdf(str(robot.description_path()))
        self._data = self._model.createData()

    def tool(self, positions: FloatArray, frame: str) -> pin.SE3:
        """T_base_tool; ``positions`` of commanded, then passive joints."""
        q = np.zeros(self._model.nq)
        for name, value in zip(self._names, positions, strict=True):
            if self._model.existJointName(name):
                q[self._model.joints[self._model.getJointId(name)].idx_q] = value
        pin.framesForwardKinematics(self._model, self._data, q)
        return self._data.oMf[self._model.getFrameId(frame, pin.FrameType.BODY)].copy()

    def moved(self, story: Story, frame: str) -> tuple[FloatArray, FloatArray]:
        """Shift [m] and rotation vector [rad] of a tool along base_link's axes."""
        before, after = self.tool(story.start, frame), self.tool(story.end, frame)
        turn = pin.log3(after.rotation @ before.rotation.T)
        return after.translation - before.translation, turn
