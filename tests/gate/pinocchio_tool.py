"""A tool's motions by pinocchio, and by the gate's path-probe."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pinocchio as pin

from fairlead.messages import FloatArray
from fairlead.paths import gate_binary
from fairlead.robot.manifest import RobotManifest

DAMPING, HARDLY = 0.02, 1e-4
LAST_STEP, MOST_STEPS = 2e-3, 12


def probe(data: FloatArray, *words: str | Path) -> FloatArray:
    """What path-probe answers, flat."""
    tool = gate_binary().with_name("path-probe")
    sent = np.ascontiguousarray(data, "<f8").tobytes()
    answer = subprocess.run([tool, *words], input=sent, stdout=subprocess.PIPE, check=True)
    return np.frombuffer(answer.stdout, "<f8")


def pinocchio_columns(robot: RobotManifest, model: pin.Model) -> dict[str, tuple[int, int]]:
    """By measured joint: its index in q and in v."""
    joints = {name: model.joints[model.getJointId(name)] for name in list(model.names)[1:]}
    assert set(joints) <= set(robot.measured_joint_names)
    return {name: (joint.idx_q, joint.idx_v) for name, joint in joints.items()}


class PinocchioTool:
    """The tool of one part, moved by the part's own joints."""

    def __init__(self, robot: RobotManifest, part: str) -> None:
        self._model = pin.buildModelFromUrdf(str(robot.description_path()))
        self._data = self._model.createData()
        self._columns = pinocchio_columns(robot, self._model)
        declared = next(one for one in robot.parts if one.name == part)
        effector = next(one for one in robot.end_effectors if one.name == declared.end_effector)
        self._frame = self._model.getFrameId(effector.tool_frame)
        self._names = list(robot.measured_joint_names)
        self._joints = declared.joints
        self.own = [self._names.index(joint) for joint in declared.joints]

    def seen(self, measured: FloatArray) -> tuple[FloatArray, pin.SE3]:
        """Jacobian of the part's joints, and the tool's pose, along the root's axes."""
        q = np.zeros(self._model.nq)
        for joint, (at, _) in self._columns.items():
            q[at] = measured[self._names.index(joint)]
        axes = pin.LOCAL_WORLD_ALIGNED
        whole = pin.computeFrameJacobian(self._model, self._data, q, self._frame, axes)
        pin.framesForwardKinematics(self._model, self._data, q)
        own = [self._columns[joint][1] for joint in self._joints]
        return whole[:, own], self._data.oMf[self._frame].copy()

    def stepped(self, measured: FloatArray, motion: FloatArray) -> tuple[FloatArray, bool]:
        """Damped steps, until one that is hardly damped moves no joint by much; whether one did."""
        after, start = measured.copy(), self.seen(measured)[1]
        target = moved(start, motion)
        for _ in range(MOST_STEPS):
            jacobian, there = self.seen(after)
            missing = motion_between(there, target)
            step = damped(jacobian, missing, DAMPING)
            rest = damped(jacobian, missing, HARDLY)
            if max(np.abs(step).max(), np.abs(rest).max()) <= LAST_STEP:
                after[self.own] += rest
                return after, True
            after[self.own] += step
        return after, False


def damped(jacobian: FloatArray, motion: FloatArray, by: float) -> FloatArray:
    """The step of least squares to a motion. Shapes ``[6, n]``, ``[6]`` -> ``[n]``."""
    square = jacobian @ jacobian.T + by**2 * np.eye(6)
    return np.asarray(jacobian.T @ np.linalg.solve(square, motion))


def moved(start: pin.SE3, motion: FloatArray) -> pin.SE3:
    """Where a tool is after a motion along the root's axes."""
    return pin.SE3(pin.exp3(motion[3:]) @ start.rotation, start.translation + motion[:3])


def motion_between(start: pin.SE3, end: pin.SE3) -> FloatArray:
    """Translation [m] and rotation vector [rad]."""
    turn = pin.log3(end.rotation @ start.rotation.T)
    return np.concatenate([end.translation - start.translation, turn])
