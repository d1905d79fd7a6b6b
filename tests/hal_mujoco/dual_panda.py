"""The two-armed robot in plain MuJoCo as tests drive it, without spread at its start."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
import numpy.typing as npt

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions

TOOLS = {"left_arm": "left_tcp", "right_arm": "right_tcp"}
OTHER = {"left_arm": "right_arm", "right_arm": "left_arm"}


class DualPanda:
    """A backend and the simulator's truth about it."""

    def __init__(self, robot: RobotManifest) -> None:
        self.robot = robot
        self.backend = MujocoBackend(robot, options=MujocoOptions(start_spread_rad=0.0))

    def run(self, commands: Mapping[str, PartCommand], ticks: int, hold: int = 0) -> None:
        """Give the same commands for some periods, then hold for others."""
        for _ in range(ticks):
            self.backend.apply(commands)
        for _ in range(hold):
            self.backend.apply({})

    def joints(self, part: str) -> list[int]:
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def positions(self, part: str) -> FloatArray:
        """Measured, of one part's joints."""
        return self.backend.read().positions[self.joints(part)]

    def tool(self, part: str) -> tuple[FloatArray, FloatArray]:
        """Position [m] and rotation matrix of an arm's tool in base_link."""
        model, data = self.backend._model, self.backend._data
        mujoco.mj_kinematics(model, data)
        base, site = data.body("base_link"), data.site(TOOLS[part])
        turn = base.xmat.reshape(3, 3).T
        return turn @ (site.xpos - base.xpos), turn @ site.xmat.reshape(3, 3)

    def joint_row(self, mode: ControlMode, part: str, values: npt.ArrayLike) -> PartCommand:
        """A row of a joint mode, padded to the robot's joints."""
        row, own = np.zeros(self.robot.n_dof), self.joints(part)
        row[own] = values
        return PartCommand(mode, "", row, tuple(own))


def tool_row(mode: ControlMode, values: npt.ArrayLike, frame: str = "base_link") -> PartCommand:
    """A row of a cartesian mode."""
    return PartCommand(mode, frame, np.array(values, dtype=float), ())
