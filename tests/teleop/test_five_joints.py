"""A person leads the tool of an arm that cannot turn it as told: the turn is left free."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.messages import Acted, FloatArray, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.description import description_tree
from fairlead.robot.manifest import load_robot
from fairlead.robot.tool_chain import ToolChain
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.session import HandDriving
from tests.teleop.drives import drive

ROBOT = load_robot("so101")
CHAIN = ToolChain(description_tree(ROBOT), "tool")


class Simulated:
    """A claim without a gate: the first row of each chunk acts, in the simulator."""

    def __init__(self) -> None:
        self.backend = MujocoBackend(ROBOT, "sim", MujocoOptions(start_spread_rad=0.0))
        self.number = 0

    def next_tick(self) -> Any:
        self.number += 1
        acted = [Acted(hold=0, verdict_id=1, row=0)] * len(ROBOT.parts)
        joints = SimpleNamespace(positions=pack_floats(self.positions()), acted=acted)
        return SimpleNamespace(number=self.number, joints=joints)

    def rows(self, part: str, mode: ControlMode, rows: FloatArray, frame: str = "") -> Any:
        return PartCommand(mode, frame, rows[0], ())

    def send(self, tick: int, row: PartCommand) -> Any:
        self.backend.apply({"arm": row})
        return SimpleNamespace(released_last=tick, code=0, outcome=0)

    def positions(self) -> FloatArray:
        return self.backend.read().positions

    def tool(self) -> FloatArray:
        return CHAIN.pose(dict(zip(ROBOT.joint_names, self.positions(), strict=True)))[0]


class Pushes:
    """A device that asks for one axis, then for nothing, then quits."""

    silence_s, help = math.inf, ""

    def __init__(self, axis: int) -> None:
        self.axes, self.left = np.eye(3)[axis], 60

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        self.left -= 1
        axes = self.axes if self.left > 20 else 0.0 * self.axes
        return Deflection(tuple(axes), clutch=True, speed=0.3, wish="" if self.left else "quit")


@pytest.mark.simulator
@pytest.mark.parametrize("axis", range(3))
def test_its_tool_goes_along_the_axis_that_it_is_told(axis: int) -> None:
    hand, claim = drive("so101", "arm", "cartesian_delta"), Simulated()
    assert hand.names == ("x", "y", "z")
    start = claim.tool()
    driving = HandDriving(
        ROBOT, hand, None, Pushes(axis), lockstep=True, horizon=16, paced=False
    )  # fmt: skip
    driving._refusals = SimpleNamespace(news=lambda _: "", forget=lambda: None, newest="")  # type: ignore[assignment]
    driving.run(claim, lambda _: None)  # type: ignore[arg-type]
    way = claim.tool() - start
    assert way[axis] > 0.03
    np.testing.assert_allclose(np.delete(way, axis), 0.0, atol=2e-3)
