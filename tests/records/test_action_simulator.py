"""The action vector: where its numbers arrive in the simulator, and what that does."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from bench.equipment.expert_episode import commands
from fairlead.errors import ConfigError
from fairlead.hal.backend import CommandCheck, PartCommand
from fairlead.messages import FloatArray, floats
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.packing import pack
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from tests.packing.vectors import ORDERS, action_map, base_velocity, delta, mode, opening
from tests.task.arm_shift import arm_shift_after_turning

pytestmark = pytest.mark.simulator

ZEROS = np.zeros(12, dtype=np.float32)
ROW = np.array([0.2, 0, 0, 0, 0, 0, 1, 0.9, 0.6, 0.5, 0.7, -1], dtype=np.float32)


def split(backend: RobosuiteBackend) -> dict[str, tuple[int, int]]:
    found = backend.env.robots[0].composite_controller._action_split_indexes
    return {name: (int(first), int(stop)) for name, (first, stop) in found.items()}


def test_action_19_the_parts_are_where_the_running_simulator_says(
    backend: RobosuiteBackend,
) -> None:
    """Parts are where the running simulator has them."""
    assert split(backend) == {
        "right": (0, 6), "right_gripper": (6, 7), "base": (7, 10), "torso": (10, 11),
    }  # fmt: skip
    assert backend.describe().simulator_order == ("right", "right_gripper", "base", "torso")


def test_action_20_another_order_of_the_same_parts_needs_no_other_code() -> None:
    """robosuite's own part order works unchanged."""
    stock = RobosuiteBackend(SimulatorOptions())
    try:
        assert split(stock) == ORDERS["stock"]
        stock.reset(0)
        stock.apply(commands(ROW))
        assert stock.last_packed is not None
        arm, grip, base, switch = ROW[:6], ROW[6:7], ROW[7:10], ROW[11:]
        wanted = np.concatenate((arm, [0.0], base, grip, switch))
        np.testing.assert_array_equal(stock.last_packed, wanted.astype(np.float32))
    finally:
        stock.close()


def test_action_21_the_hal_offers_the_modes_that_the_training_controllers_are(
    backend: RobosuiteBackend,
) -> None:
    """The HAL offers the training controllers' modes."""
    running = backend.env.robots[0].composite_controller.part_controllers
    assert {name: type(one).__name__ for name, one in running.items()} == {
        "right": "OperationalSpaceController",
        "right_gripper": "SimpleGripController",
        "base": "MobileBaseJointVelocityController",
        "torso": "JointPositionController",
    }
    assert running["right"].output_max.tolist() == [0.05] * 3 + [0.5] * 3
    parts = {part.name: part for part in backend.describe().parts}
    ranges = {
        (name, ControlMode(entry.mode).yaml_name): floats(entry.upper).tolist()
        for name, part in parts.items()
        for entry in part.ranges
    }
    assert ranges["arm", "cartesian_delta"] == [0.05] * 3 + [0.5] * 3
    assert ranges["gripper", "gripper_position"] == [0.08]
    assert ranges["base", "joint_velocity"] == [1.0, 1.0, 1.5]


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_action_22_the_base_values_are_written_into_the_base_slot(order: str) -> None:
    """Base velocities land in the base's inputs, wherever they are."""
    first, stop = ORDERS[order]["base"]
    command = {"base": base_velocity(base_x=0.5, base_y=-0.25, base_yaw=0.75)}
    vector = pack(command, action_map(ORDERS[order]), ZEROS)
    assert vector[first:stop].tolist() == [0.5, -0.25, 0.5]
    assert np.count_nonzero(vector) == 4  # and the switch


@pytest.mark.parametrize("order", sorted(ORDERS))
def test_action_23_base_yaw_alone_reaches_its_own_input(order: str) -> None:
    """base_yaw alone reaches its own input."""
    first, stop = ORDERS[order]["base"]
    vector = pack({"base": base_velocity(base_yaw=0.75)}, action_map(ORDERS[order]), ZEROS)
    assert vector[first:stop].tolist() == [0.0, 0.0, 0.5]


def test_action_24_joints_that_are_not_of_one_part_are_an_error() -> None:
    """Joints that are not of one part are refused."""
    with pytest.raises(
        ConfigError, match=r"part base: expected active joints out of \[0, 1, 2\], got \[2, 3\]"
    ):
        CommandCheck(load_robot("panda_mobile"), "sim").check(
            "base", base_velocity(base_yaw=0.1, panda_joint1=0.1)
        )


def test_action_25_a_width_that_does_not_fit_is_an_error_with_both_numbers() -> None:
    """Three numbers where eleven are expected are refused."""
    narrow = PartCommand(ControlMode.JOINT_VELOCITY, "", np.zeros(3), (0, 1, 2))
    with pytest.raises(
        ConfigError, match=r"part base: expected 11 value\(s\) of joint_velocity, got shape \[3\]"
    ):
        CommandCheck(load_robot("panda_mobile"), "sim").check("base", narrow)


def test_action_26_the_switch_is_the_last_number_and_nothing_overrides_it() -> None:
    """composite_mode goes last, as the policy wrote it."""
    for value in (-1.0, -0.25, 0.0, 0.4, 1.0):
        vector = pack({"composite": mode(value)}, action_map(ORDERS["records"]), ZEROS)
        assert vector[-1] == np.float32(value)


def test_action_27_without_a_switch_the_arm_is_manipulated() -> None:
    """Without composite_mode the HAL writes -1.0."""
    assert pack({"arm": delta(np.zeros(6))}, action_map(ORDERS["records"]), ZEROS)[-1] == -1.0


def test_action_28_minus_one_anchors_to_the_achieved_pose_and_plus_one_to_the_goal(
    backend: RobosuiteBackend,
) -> None:
    """The switch anchors the arm to its achieved pose or its goal."""
    assert arm_shift_after_turning(backend, -1.0) > 0.10
    assert arm_shift_after_turning(backend, 1.0) < 0.01


def test_action_29_a_hal_without_a_composite_controller_takes_the_switch_and_does_nothing() -> None:
    """In plain MuJoCo the switch changes nothing."""
    plain = yaml.safe_load((robot_dir("panda") / "robot.yaml").read_text())
    mobile = yaml.safe_load((robot_dir("panda_mobile") / "robot.yaml").read_text())
    plain["parts"] += [part for part in mobile["parts"] if part["name"] == "composite"]
    plain["safety"]["sim"]["parts"]["composite"] = mobile["safety"]["sim"]["parts"]["composite"]
    panda = RobotManifest.model_validate(plain)
    told, untold = (MujocoBackend(panda) for _ in range(2))
    for world in (told, untold):
        world.reset(0)
    start = told.read().positions
    target = start[: panda.n_dof] + np.append(np.full(7, 0.1), 0.0)
    move = {"arm": PartCommand(ControlMode.JOINT_POSITION, "", target, tuple(range(7)))}
    for value in (1.0, -1.0, 0.3):
        told.apply(move | {"composite": mode(value)})
        untold.apply(move)
    assert np.abs(told.read().positions - start).max() > 0.01, "the arm moves"
    assert told.read().positions.tobytes() == untold.read().positions.tobytes()


def test_action_30_the_torso_gets_zero_and_stays_where_it_is(backend: RobosuiteBackend) -> None:
    """The torso gets zero and stays."""
    backend.reset(0)
    start = backend.read().positions
    for _ in range(40):
        backend.apply(commands(ROW))
        assert backend.last_packed is not None and backend.last_packed[10] == 0.0
    moved = np.abs(backend.read().positions - start)
    assert (moved[:3] > 0.1).all() and moved[3:10].max() > 0.1, "base and arm move"
    assert moved[13] < 0.005


def test_action_31_nothing_is_remembered_for_the_torso() -> None:
    """The torso's input does not depend on the tick before."""
    slots = action_map(ORDERS["records"])
    assert pack({"gripper": opening(0.0)}, slots, np.ones(12, dtype=np.float32))[10] == 0.0


def test_action_32_the_base_moves_where_a_policy_drives_it(backend: RobosuiteBackend) -> None:
    """Each base number moves its own joint."""

    def moved(*base: float) -> FloatArray:
        backend.reset(0)
        row = np.zeros(12, dtype=np.float32)
        row[6:10], row[11] = (-1, *base), -1
        start = backend.read().positions[:3].copy()
        for _ in range(20):
            backend.apply(commands(row))
        return backend.read().positions[:3] - start

    emitted = (0.468, 0.132, -0.014)
    assert moved(*emitted)[0] > 0.1
    for joint, value in enumerate(emitted):
        alone = moved(*(value if one == joint else 0.0 for one in range(3)))
        assert np.abs(alone).argmax() == joint and np.sign(alone[joint]) == np.sign(value), alone
