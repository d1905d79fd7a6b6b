"""Where an arm's tool and links are, by the robot's description and its gate file, in pinocchio."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest

SAMPLES = 11


class ArmModel:
    """Positions are of commanded, then passive joints."""

    def __init__(self, robot: RobotManifest, tool: str) -> None:
        self._names = robot.measured_joint_names
        self._model = pin.buildModelFromUrdf(str(robot.description_path()))
        self._data = self._model.createData()
        self._tool = self._model.getFrameId(tool, pin.FrameType.BODY)

    def _configuration(self, positions: FloatArray) -> FloatArray:
        q: FloatArray = np.zeros(self._model.nq)
        for name, value in zip(self._names, positions, strict=True):
            if self._model.existJointName(name):
                q[self._model.joints[self._model.getJointId(name)].idx_q] = value
        return q

    def tool(self, positions: FloatArray) -> FloatArray:
        """The tool's origin along the root's axes [m]."""
        pin.framesForwardKinematics(self._model, self._data, self._configuration(positions))
        return np.array(self._data.oMf[self._tool].translation)

    def jacobian(self, positions: FloatArray, joints: tuple[str, ...]) -> FloatArray:
        """Of the tool's origin along the root's axes, one column for each of ``joints``."""
        full = pin.computeFrameJacobian(
            self._model, self._data, self._configuration(positions), self._tool,
            pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
        )  # fmt: skip
        columns = [self._model.joints[self._model.getJointId(name)].idx_v for name in joints]
        return np.array(full[:, columns])

    def depth(self, positions: FloatArray, capsules: Any, volume: Any) -> float:
        """How deep the deepest of some capsules is in a box [m]; negative: how far outside."""
        pin.framesForwardKinematics(self._model, self._data, self._configuration(positions))
        lower, upper = np.array(volume["lower"]), np.array(volume["upper"])
        deepest = -np.inf
        for capsule in capsules:
            frame = self._model.getFrameId(capsule["link"], pin.FrameType.BODY)
            for share in np.linspace(0.0, 1.0, SAMPLES):
                own = (1 - share) * np.array(capsule["a"]) + share * np.array(capsule["b"])
                point = self._data.oMf[frame].act(own)
                outside = np.linalg.norm(point - np.clip(point, lower, upper))
                deepest = max(deepest, capsule["radius"] - float(outside))
        return deepest
