"""Torques from rest, for as long as they are released, and where they lead."""

from __future__ import annotations

import numpy as np

from bench.measure_limits.driven_robot import Moment
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from tests.soundness.attack import ROWS_MOST, Parts, everything
from tests.soundness.chunk_rows import Row

PAUSE_TICKS = 20


class Torques:
    """Bursts of one torque on one joint or all of them; between them velocities of zero."""

    def __init__(self, robot: RobotManifest, rng: np.random.Generator) -> None:
        self.ticks, self.claims = 200, everything(robot)
        self._robot, self._rng = robot, rng
        able = [p for p in robot.parts if ControlMode.JOINT_TORQUE in p.control_modes]
        self._part = able[int(rng.integers(len(able)))]
        self._joints = [robot.joint_names.index(name) for name in self._part.joints]
        self._rest = Parts(robot, {self._part.name: ControlMode.JOINT_VELOCITY})
        self._rows = int(rng.integers(1, ROWS_MOST + 1))
        self._pause_until = 0

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """As `Attack.chunk`."""
        if tick < self._pause_until:
            return [self._rest.row({self._part.name: np.zeros(len(self._joints))}, now)]
        self._pause_until = tick + self._rows + PAUSE_TICKS
        values = np.zeros(self._robot.n_dof)
        values[self._joints] = self._torque()
        told = PartCommand(ControlMode.JOINT_TORQUE, "", values, tuple(self._joints))
        return [{self._part.name: told} for _ in range(self._rows)]

    def answered(self, source: str, row: Row | None) -> None:
        """As `Attack.answered`."""
        resting = row is not None and row[self._part.name].mode is ControlMode.JOINT_VELOCITY
        self._rest.go_on_after(row if resting else None)

    def _torque(self) -> FloatArray:
        limits = self._robot.profile("sim").parts[self._part.name].joint_torque
        assert limits is not None
        efforts = np.array([self._robot.joints[joint].effort_limit for joint in self._joints])
        most = np.minimum(efforts, limits.step_limits)
        scale = 10.0 ** self._rng.uniform(-2.0, 0.0)
        found = np.sign(self._rng.uniform(-1.0, 1.0, len(most))) * scale * most
        if self._rng.random() < 0.5:
            alone = int(self._rng.integers(len(most)))
            found[np.arange(len(most)) != alone] = 0.0
        return np.asarray(found)
