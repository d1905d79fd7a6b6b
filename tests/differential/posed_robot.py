"""A second mind on where a robot's links are and what is near them: pinocchio and coal."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio

from fairlead.messages import FloatArray


class PosedRobot:
    """One robot's shape and volumes, by its gate file and its description. ``place`` it first."""

    def __init__(self, data: dict[str, Any], urdf: Path) -> None:
        self._data = data
        self._model: Any = pinocchio.buildModelFromUrdf(str(urdf))
        self._state: Any = self._model.createData()
        measured = [*data["joints"], *data["passive_joints"]]
        self.names = [joint["name"] for joint in measured]
        self._q_of = {
            index: self._model.joints[self._model.getJointId(name)].idx_q
            for index, name in enumerate(self.names)
            if self._model.existJointName(name)
        }
        self._parts = {part["name"]: part for part in data["parts"]}

    def own(self, part: str) -> list[int]:
        return [self.names.index(name) for name in self._parts[part]["joints"]]

    def place(self, positions: FloatArray) -> None:
        q = pinocchio.neutral(self._model)
        for index, at in self._q_of.items():
            q[at] = positions[index]
        pinocchio.computeJointJacobians(self._model, self._state, q)
        pinocchio.updateFramePlacements(self._model, self._state)

    def frame(self, link: str) -> Any:
        return self._state.oMf[self._model.getFrameId(link)]

    def jacobian(self, positions: FloatArray, part: str) -> FloatArray:
        self.place(positions)
        return self.columns(self._parts[part]["tool_frame"], part)

    def columns(self, link: str, part: str) -> FloatArray:
        """Of the link's Jacobian, those of a part's joints."""
        frame = self._model.getFrameId(link)
        whole = pinocchio.getFrameJacobian(
            self._model, self._state, frame, pinocchio.LOCAL_WORLD_ALIGNED
        )
        return np.asarray(whole[:, [self._q_of[joint] for joint in self.own(part)]])

    def volume_margin(self, part: str) -> float:
        margin = math.inf
        for link in {one["tool_frame"] for one in self._parts.values()} - {None}:
            if part != "base" and not self.columns(link, part).any():
                continue  # another part's, and this one does not move it
            tool = self.frame(link).translation
            for volume in self._data["workspace"]["volumes"]:
                inside = np.minimum(tool - volume["lower"], np.subtract(volume["upper"], tool))
                margin = min(margin, float(inside.min()))
        return margin

    def _capsule(self, index: int) -> tuple[coal.Capsule, coal.Transform3s]:
        shape = self._data["collision"]["capsules"][index]
        a, b = (self.frame(shape["link"]).act(np.array(shape[end])) for end in "ab")
        length = float(np.linalg.norm(b - a))
        axis = (b - a) / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
        turn = pinocchio.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis)
        place = coal.Transform3s(turn.toRotationMatrix(), 0.5 * (a + b))
        return coal.Capsule(shape["radius"], length), place

    def capsule_margin(self) -> float:
        shapes = [self._capsule(i) for i in range(len(self._data["collision"]["capsules"]))]
        distances = [
            coal.distance(*shapes[i], *shapes[j], coal.DistanceRequest(), coal.DistanceResult())
            for i, j in self._data["collision"]["pairs"]
        ]
        return min(distances, default=math.inf) - float(self._data["collision"]["clearance"])
