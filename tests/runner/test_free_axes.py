"""Deltas that leave axes of a tool free: filled in with what the arm does anyway."""

from __future__ import annotations

import numpy as np
import pytest

from bench.equipment.kinematics import Kinematics
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.routes import Route, resolve_routes
from fairlead.skill.slots import Slot
from fairlead_skill_runner.free_axes import free_axes


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
