"""A robot without physics: it makes of each row the share it is told to, and brakes as declared."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.soundness.prediction import TARGETS, Prediction
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment, Tick


class ShareRobot:
    """Stands in for a `DrivenRobot` in a `GateLoop`. Positions are of every measured joint.

    Args:
        file: the robot's gate file, for gains, stop lags and decelerations.
    """

    def __init__(self, robot: RobotManifest, file: dict[str, Any]) -> None:
        self.robot, self._period_s = robot, robot.tick_period_ns * 1e-9
        self.prediction = Prediction(robot, file)
        joints, base = file["joints"], file["base"]
        react_s = np.zeros(len(joints))
        if base is not None:
            own = [robot.joint_names.index(name) for name in base["joints"]]
            react_s[own] = base["reaction_s"]
        self._react_s = react_s
        self._lag_s = np.array([joint.get("stop_lag") or 0.0 for joint in joints])
        self._fastest = np.array([joint.get("velocity_limit") or np.inf for joint in joints])
        self._slowing = np.array([joint.get("acceleration_limit") or np.inf for joint in joints])
        self._shares = np.zeros((0, 0))
        self._positions = np.zeros(0)
        self._row = 0

    def begin(self, positions: FloatArray, shares: FloatArray) -> None:
        """Stand there. shares: of each row and part, as in `Prediction.follow`."""
        self._positions, self._shares, self._row = positions, shares, 0
        self.prediction.forget_goals()

    def reset(self, seed: int) -> Moment:
        """Where it was told to begin."""
        return self._moment(self._positions, np.zeros(len(self._positions)))

    def step(self, kind: str, before: Moment, commands: Mapping[str, PartCommand]) -> Tick:
        """One row of what is commanded; what is not, stays."""
        shares = self._shares[self._row : self._row + 1]
        [after] = self.prediction.follow(before.positions, [commands], shares)
        self._row += bool(commands)
        moved = (after - before.positions) / self._period_s
        return Tick(kind, before, self._moment(after, moved), commands, is_free=True)

    def stopped(self, done: Tick) -> FloatArray:
        """Where it comes to rest if it is told to hold after this tick."""
        count = len(self.robot.joint_names)
        speed = np.clip(done.after.velocities[:count], -self._fastest, self._fastest)
        told = [index for part in done.commands for index in self._joints(part)]
        targets = [
            index
            for part, command in done.commands.items()
            if command.mode in (*TARGETS, ControlMode.CARTESIAN_POSE)
            for index in self._joints(part)
        ]
        lag_s = self._lag_s.copy()
        lag_s[targets] = 0.0
        way = speed * (self._react_s + lag_s) + 0.5 * speed * np.abs(speed) / self._slowing
        end = done.after.positions.copy()
        end[told] += way[told]
        return end

    def _joints(self, part: str) -> list[int]:
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def _moment(self, positions: FloatArray, velocities: FloatArray) -> Moment:
        return Moment(positions, velocities, np.zeros(len(positions)), {}, np.zeros(3))
