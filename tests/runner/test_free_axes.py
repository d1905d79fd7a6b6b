"""Deltas that leave axes of a tool free: filled in with what the arm does anyway."""

from __future__ import annotations

import numpy as np
import pytest

from bench.equipment.kinematics import Kinematics
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.routes import Route, resolve_routes
from fairlead.skill.slots import Slot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions
from fairlead_skill_runner.run_setup import free_axes


def five_joints() -> RobotManifest:
    """An arm whose last two joints no command moves."""
    robot = load_robot("panda_mobile")
    arm = robot.part("arm")
    short = arm.model_copy(update={"joints": arm.joints[:5]})
    return robot.model_copy(
        update={"parts": tuple(short if part == arm else part for part in robot.parts)}
    )


def route(robot: RobotManifest, axes: tuple[int, ...]) -> Route:
    slot = Slot(range=(0, len(axes) - 1), control_mode="cartesian_delta", ee="gripper",
                frame="base_link", axes=axes)  # fmt: skip
    (found,) = resolve_routes(ActionContract(dim=len(axes), slots=(slot,)), robot)
    return found


@pytest.mark.parametrize("axes", [(0, 1, 2), (0, 2), (0, 1, 2, 5)])
def test_the_joints_that_make_the_told_axes_make_the_filled_in_ones(axes: tuple[int, ...]) -> None:
    robot = five_joints()
    one = route(robot, axes)
    (free,) = free_axes([one], robot).values()
    home = robot.home
    assert home is not None
    names = robot.measured_joint_names
    positions = np.array([home.positions.get(name, 0.0) for name in names])
    rows = np.zeros((4, 6))
    rows[:, list(axes)] = np.array([0.004, -0.003, 0.005, 0.02])[: len(axes)]
    filled = free.completed(rows, positions)
    np.testing.assert_array_equal(filled[:, list(axes)], rows[:, list(axes)])
    others = [axis for axis in range(6) if axis not in axes]
    assert np.abs(filled[:, others]).max() > 1e-3
    # Whatever five joints do, they do that motion to within what damping takes off.
    kinematics = Kinematics(robot.description_path(), names)
    own = [names.index(name) for name in robot.part("arm").joints]
    columns = []
    for joint in own:
        speed = np.zeros(len(names))
        speed[joint] = 1.0
        tool = robot.end_effector("gripper").tool_frame
        columns.append(kinematics.twist(positions, speed, tool, "base_link"))
    jacobian = np.stack(columns, axis=1)
    made = jacobian @ np.linalg.lstsq(jacobian, filled[0], rcond=None)[0]
    np.testing.assert_allclose(made, filled[0], atol=0.05 * np.abs(rows[0]).max())


def test_a_delta_of_all_axes_leaves_none_free() -> None:
    robot = five_joints()
    assert free_axes([route(robot, (0, 1, 2, 3, 4, 5))], robot) == {}


def test_a_simulated_arm_of_five_joints_goes_where_its_tool_is_told() -> None:
    """Told not to turn it is left far behind."""
    robot = load_robot("ur5e")
    arm = robot.part("arm")
    short = arm.model_copy(update={"joints": arm.joints[:5]})
    wrist = arm.model_copy(update={"name": "wrist", "joints": arm.joints[5:], "end_effector": None,
                                   "modes": ("joint_position",)})  # fmt: skip
    robot = robot.model_copy(update={"parts": (short, wrist, robot.part("gripper"))})
    safety = robot.profile("sim")
    limits = {**safety.parts, "wrist": safety.parts["arm"]}
    robot = robot.model_copy(
        update={"safety": {"sim": safety.model_copy(update={"parts": limits})}}
    )
    kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
    (free,) = free_axes([route(robot, (0, 1, 2))], robot).values()
    row, ticks = np.array([0.0, 0.002, 0.001, 0.0, 0.0, 0.0]), 60

    def short_of(filled_in: bool) -> float:
        backend = MujocoBackend(robot, options=MujocoOptions(start_spread_rad=0.0))
        start = kinematics.pose(backend.read().positions, "grip_site", "base_link")[0]
        for tick in range(ticks + 20):
            rows = row[None] * (tick < ticks)
            if filled_in:
                rows = free.completed(rows, backend.read().positions)
            told = PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", rows[0], ())
            backend.apply({"arm": told})
        end = kinematics.pose(backend.read().positions, "grip_site", "base_link")[0]
        return float(np.linalg.norm(end - start - row[:3] * ticks))

    assert short_of(filled_in=True) < 0.005
    assert short_of(filled_in=False) > 0.02
