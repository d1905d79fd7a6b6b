"""Where released rows lead, by pinocchio: from the meaning of the modes, not from the gate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from bench.equipment.kinematics import rotation_of
from bench.soundness.chunk_rows import Row
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest

DAMPINGS = (0.002, 0.01, 0.05)
"""Of a tool's controller [m]: what campaigns draw from."""
ITERATIONS = 400
REACHED = 1e-6
STILL = 1e-10
"""A step that no joint makes: nearer the joints, five perhaps, do not come [rad or m]."""
TARGETS = (ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT)


class NotReachedError(Exception):
    """No end of the search for the joints that bring the tool there."""


class Prediction:
    """One robot. Positions are of every measured joint, commanded ones first.

    Args:
        file: its gate file, for the gains.

    Attributes:
        damping: of the least squares by which a tool's controller finds joints [m].
    """

    def __init__(self, robot: RobotManifest, file: dict[str, Any]) -> None:
        self._robot, self._period_s = robot, robot.tick_period_ns * 1e-9
        self.damping = 0.01
        self._model: Any = pinocchio.buildModelFromUrdf(str(robot.description_path()))
        self._data: Any = self._model.createData()
        names = robot.measured_joint_names
        self._columns = {
            index: self._model.joints[self._model.getJointId(name)]
            for index, name in enumerate(names)
            if self._model.existJointName(name)
        }
        self._gains = {
            (part["name"], mode): tuple(block["gain"])
            for part in file["parts"]
            for mode, block in part["modes"].items()
            if "gain" in block
        }
        base = file["base"]
        self._against_yaw = bool(base) and base["command_frame"] == "against_yaw"
        self._yaw_axis = np.array(base["yaw_axis"]) if base else np.zeros(2)
        self._goals: dict[str, Any] = {}
        self._tools = {
            part.name
            for part in robot.parts
            if part.end_effector is not None and len(part.joints) > 1
        }

    def forget_goals(self) -> None:
        """Each tool goes on from where it is."""
        self._goals = {}

    def follow(
        self, start: FloatArray, rows: Sequence[Row], shares: FloatArray
    ) -> list[FloatArray]:
        """Positions after each row.

        Where the composite switch is up a tool goes on from the goal of the row before, of this
        call or the last one, not from where it is. The goal of a tool that holds is where it was
        when the tick began.

        Args:
            shares: per row, where in each mode's gain its motion lies: 0 lower end, 1 upper end;
                ``[rows]`` for all parts alike, ``[rows, parts]`` for each part in robot.yaml's
                order.

        Raises:
            NotReachedError: where a controller would search on and on.
        """
        found, q = [], start.copy()
        order = [part.name for part in self._robot.parts]
        for row, share in zip(rows, shares, strict=True):
            later = q.copy()
            if not any(_is_up(command) for command in row.values()):
                self.forget_goals()
            for part, command in row.items():
                low, high = self._gains.get((part, command.mode.yaml_name), (1.0, 1.0))
                at = float(np.broadcast_to(share, len(order))[order.index(part)])
                self._move(part, command, low + (high - low) * at, q, later)
            for part in self._tools - row.keys():
                self._goals[part] = self._tool(part, q)
            q = later
            found.append(q)
        return found

    def depends_on_shares(self, row: Row) -> bool:
        """Whether a row's motion is anything between two ends."""
        gains = [
            self._gains.get((part, one.mode.yaml_name), (1.0, 1.0)) for part, one in row.items()
        ]
        return any(low != high for low, high in gains)

    def _move(
        self, part: str, command: PartCommand, gain: float, q: FloatArray, later: FloatArray
    ) -> None:
        mode, values = command.mode, command.values
        own = [self._robot.joint_names.index(name) for name in self._robot.part(part).joints]
        per_tick = 1.0 if mode is ControlMode.CARTESIAN_DELTA else self._period_s
        if mode in TARGETS:
            later[list(command.active)] = values[list(command.active)]
        elif mode is ControlMode.JOINT_VELOCITY:
            later[: len(values)] += gain * per_tick * self._told(part, values, q)
        elif mode in (ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST):
            tool = self._tool(part, q)
            goal = _moved(self._goals.get(part, tool), per_tick * values)
            self._goals[part] = goal
            turn = pinocchio.log3(goal.rotation @ tool.rotation.T)
            way = gain * np.concatenate([goal.translation - tool.translation, turn])
            self._reach(part, own, later, _moved(tool, way))
        elif mode is ControlMode.CARTESIAN_POSE:
            self._reach(part, own, later, pinocchio.SE3(rotation_of(values[3:]), values[:3]))
        elif mode is ControlMode.BODY_TWIST:
            self._drive(own, gain * per_tick * values, later)
        elif mode is ControlMode.GRIPPER_POSITION:
            later[own[0]] = values[0]
        elif mode is ControlMode.GRIPPER_BINARY:
            joint = self._robot.joints[own[0]]
            later[own[0]] = joint.upper if values[0] == 0.0 else joint.lower

    def _told(self, part: str, values: FloatArray, q: FloatArray) -> FloatArray:
        """Velocities of the joints; a base's slides may be told against its yaw."""
        told = values.copy()
        if self._against_yaw and part == "base":
            x, y, yaw = (self._robot.joint_names.index(n) for n in self._robot.part(part).joints)
            told[[x, y]] = _plane(-q[yaw]) @ values[[x, y]]
        return told

    def _drive(self, own: list[int], way: FloatArray, later: FloatArray) -> None:
        """base_link's origin moves along its own axes; the slides carry the yaw axis."""
        yaw = later[own[2]]
        origin = later[own[:2]] + self._yaw_axis - _plane(yaw) @ self._yaw_axis
        origin = origin + _plane(yaw + way[5] / 2.0) @ way[:2]
        later[own[2]] = yaw + way[5]
        later[own[:2]] = origin - self._yaw_axis + _plane(yaw + way[5]) @ self._yaw_axis

    def _reach(self, part: str, own: list[int], q: FloatArray, goal: Any) -> None:
        frame = self._frame(part)
        columns = [self._columns[joint].idx_v for joint in own]
        local = pinocchio.LOCAL_WORLD_ALIGNED
        for _ in range(ITERATIONS):
            tool = self._tool(part, q)
            turn = pinocchio.log3(goal.rotation @ tool.rotation.T)
            error = np.concatenate([goal.translation - tool.translation, turn])
            if np.abs(error).max() < REACHED:
                return
            whole = pinocchio.computeFrameJacobian(
                self._model, self._data, self._full(q), frame, local
            )
            jacobian = whole[:, columns]
            damped = jacobian @ jacobian.T + self.damping**2 * np.eye(6)
            step = jacobian.T @ np.linalg.solve(damped, error)
            q[own] += step
            if np.abs(step).max() < STILL:
                return
        raise NotReachedError

    def _tool(self, part: str, q: FloatArray) -> Any:
        pinocchio.framesForwardKinematics(self._model, self._data, self._full(q))
        return self._data.oMf[self._frame(part)].copy()

    def _frame(self, part: str) -> int:
        effector = self._robot.part(part).end_effector
        assert effector is not None
        return int(self._model.getFrameId(self._robot.end_effector(effector).tool_frame))

    def _full(self, q: FloatArray) -> FloatArray:
        full: FloatArray = np.asarray(pinocchio.neutral(self._model), dtype=np.float64)
        for index, joint in self._columns.items():
            if joint.nq == 2:
                full[joint.idx_q : joint.idx_q + 2] = math.cos(q[index]), math.sin(q[index])
            else:
                full[joint.idx_q] = q[index]
        return full


def _is_up(command: PartCommand) -> bool:
    return command.mode is ControlMode.COMPOSITE_MODE and command.values[0] >= 0.0


def _moved(pose: Any, way: FloatArray) -> Any:
    """Shifted and turned, along the root's axes."""
    return pinocchio.SE3(pinocchio.exp3(way[3:]) @ pose.rotation, pose.translation + way[:3])


def _plane(angle: float) -> FloatArray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])
