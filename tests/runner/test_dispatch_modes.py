"""Every mode's slot becomes its part, on a robot of two arms: width, order, unit, frame, mask."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import ActionPart, floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.routes import resolve_routes
from fairlead.skill.slots import MODE_NAMES
from fairlead_skill_runner.candidate import dispatch

DUAL, MOBILE = load_robot("dual_panda"), load_robot("panda_mobile")
LEFT = {"ee": "left_tool", "frame": "base_link"}
RIGHT = {"ee": "right_tool", "frame": "base_link"}
MIXED = ["right_joint4", "right_joint1", "right_joint7"]
"""Joints in an order of the policy's own; on the wire they are joints 11, 8 and 14."""


def emitted(width: int) -> np.ndarray:
    """One row whose numbers differ in size and sign, each exact in float32."""
    return np.array([[(-1) ** k * (k + 1) / 16.0 for k in range(width)]], dtype=np.float32)


def one(robot: RobotManifest, slot: dict[str, Any], row: np.ndarray) -> ActionPart:
    width = row.shape[1]
    contract = ActionContract.model_validate(
        {"dim": width, "slots": [{"range": [0, width - 1], **slot}]}
    )
    [part] = dispatch(resolve_routes(contract, robot), row, width)
    return part


CARTESIAN = [
    ("cartesian_pose", 7, LEFT, "left_arm"),
    ("cartesian_pose", 7, RIGHT, "right_arm"),
    ("cartesian_delta", 6, LEFT, "left_arm"),
    ("cartesian_delta", 6, RIGHT, "right_arm"),
    ("cartesian_twist", 6, LEFT, "left_arm"),
    ("cartesian_twist", 6, RIGHT, "right_arm"),
]


@pytest.mark.parametrize(("mode", "width", "fields", "part"), CARTESIAN)
def test_a_cartesian_slot_goes_to_the_arm_of_its_end_effector_in_its_frame(
    mode: str, width: int, fields: dict[str, Any], part: str
) -> None:
    row, scale = emitted(width), [0.5 * (k + 1) for k in range(width)]
    found = one(DUAL, {"control_mode": mode, **fields, "scale": scale}, row)
    assert DUAL.part_names[found.part] == part
    assert (found.mode, found.frame_id) == (ControlMode[mode.upper()], "base_link")
    assert found.active == ()
    np.testing.assert_array_equal(floats(found.values, width), row.astype(float) * scale)


@pytest.mark.parametrize("mode", ["joint_position", "joint_velocity"])
def test_joints_named_in_any_order_go_to_their_own_columns_and_nowhere_else(mode: str) -> None:
    found = one(DUAL, {"control_mode": mode, "joint_names": MIXED, "scale": [2, 3, 4]}, emitted(3))
    assert DUAL.part_names[found.part] == "right_arm"
    assert (found.mode, found.frame_id) == (ControlMode[mode.upper()], "")
    assert found.active == (8, 11, 14)
    wire = np.zeros(21)
    wire[[11, 8, 14]] = [2 / 16, -3 * 2 / 16, 4 * 3 / 16]
    np.testing.assert_array_equal(floats(found.values, 21)[0], wire)


def test_a_hand_is_commanded_by_its_joints() -> None:
    names = list(reversed(DUAL.part("right_hand").joints))
    found = one(DUAL, {"control_mode": "dex_hand_joint", "joint_names": names}, emitted(6))
    assert DUAL.part_names[found.part] == "right_hand"
    assert found.mode == ControlMode.DEX_HAND_JOINT
    assert found.active == tuple(range(15, 21))
    np.testing.assert_array_equal(floats(found.values, 21)[0, 15:], emitted(6)[0, ::-1])


def test_degrees_become_radians_for_every_joint_whatever_the_order() -> None:
    contract = ActionContract(
        dim=3, joint_names=("right_joint2", "left_joint7", "left_joint1"), joint_unit="deg"
    )
    row = np.array([[90.0, -30.0, 12.0]], dtype=np.float32)
    left, right = dispatch(resolve_routes(contract, DUAL), row, 3)
    assert [DUAL.part_names[part.part] for part in (left, right)] == ["left_arm", "right_arm"]
    assert (left.active, right.active) == ((0, 6), (9,))
    degree = math.pi / 180.0
    np.testing.assert_array_equal(floats(left.values, 21)[0, [0, 6]], [12 * degree, -30 * degree])
    assert floats(right.values, 21)[0, 9] == 90 * degree


@pytest.mark.parametrize(
    ("slot", "outputs", "wire"),
    [
        # closed is +1, as Franka's own interfaces have it
        ({"threshold": 0.0}, [-1.0, -1e-7, 0.0, 0.3, 1.0], [0, 0, 1, 1, 1]),
        # open is +1
        ({"scale": -1.0, "threshold": 0.0}, [-1.0, 0.2, 1.0], [1, 0, 0]),
        # a probability of closing
        ({"threshold": 0.5}, [0.0, 0.49, 0.5, 1.0], [0, 0, 1, 1]),
        # without a threshold the numbers are the gate's to judge
        ({}, [0.0, 1.0, 0.4, -1.0], [0, 1, np.float32(0.4), -1]),
        ({"scale": 0.5, "offset": 0.5}, [-1.0, 1.0, 0.5], [0, 1, 0.75]),
    ],
)
def test_a_binary_gripper_is_open_below_its_threshold_and_closed_from_it_on(
    slot: dict[str, Any], outputs: list[float], wire: list[float]
) -> None:
    rows = np.array(outputs, dtype=np.float32)[:, None]
    found = one(DUAL, {"control_mode": "gripper_binary", "ee": "left_tool", **slot}, rows)
    assert DUAL.part_names[found.part] == "left_gripper"
    assert found.mode == ControlMode.GRIPPER_BINARY
    np.testing.assert_array_equal(floats(found.values), np.array(wire, dtype=float))


@pytest.mark.parametrize("output", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_passes_a_threshold_unchanged_for_the_gate_to_stop(
    output: float,
) -> None:
    slot = {"control_mode": "gripper_binary", "ee": "left_tool", "threshold": 0.0}
    found = one(DUAL, slot, np.array([[output]], dtype=np.float32))
    np.testing.assert_array_equal(floats(found.values), [output])


def test_an_opening_a_body_twist_and_a_switch_are_as_they_were() -> None:
    found = one(DUAL, {"control_mode": "gripper_position", "ee": "left_tool", "scale": 0.04,
                       "offset": 0.04}, emitted(1))  # fmt: skip
    assert DUAL.part_names[found.part] == "left_gripper"
    np.testing.assert_array_equal(floats(found.values), [0.04 / 16 + 0.04])
    found = one(MOBILE, {"control_mode": "body_twist", "axes": [0, 1, 5]}, emitted(3))
    assert (MOBILE.part_names[found.part], found.frame_id) == ("base", "base_link")
    np.testing.assert_array_equal(floats(found.values), [1 / 16, -2 / 16, 0, 0, 0, 3 / 16])
    found = one(MOBILE, {"control_mode": "composite_mode"}, emitted(1))
    assert MOBILE.part_names[found.part] == "composite"
    np.testing.assert_array_equal(floats(found.values), [1 / 16])


def test_every_mode_a_slot_can_name_is_dispatched_above() -> None:
    shown = {mode for mode, *_ in CARTESIAN} | {
        *("joint_position", "joint_velocity", "dex_hand_joint"),
        *("gripper_binary", "gripper_position", "body_twist", "composite_mode"),
    }
    assert shown == set(MODE_NAMES)


def test_both_arms_both_hands_travel_in_one_chunk_in_part_order() -> None:
    slots = [
        {"range": [0, 5], "control_mode": "cartesian_twist", **RIGHT},
        {"range": [6, 6], "control_mode": "gripper_binary", "ee": "left_tool", "threshold": 0.0},
        {"range": [7, 12], "control_mode": "cartesian_delta", **LEFT},
        {"range": [13, 13], "control_mode": "dex_hand_joint",
         "joint_names": ["right_index_joint1"]},
    ]  # fmt: skip
    contract = ActionContract.model_validate({"dim": 14, "slots": slots})
    parts = dispatch(resolve_routes(contract, DUAL), emitted(14), 14)
    assert [DUAL.part_names[part.part] for part in parts] == list(DUAL.part_names)
    numbers = emitted(14)[0]
    np.testing.assert_array_equal(floats(parts[0].values), numbers[7:13])
    np.testing.assert_array_equal(floats(parts[1].values), [1.0])
    np.testing.assert_array_equal(floats(parts[2].values), numbers[:6])
    assert floats(parts[3].values)[17] == numbers[13]


def test_one_arm_in_two_modes_at_once_is_refused() -> None:
    slots = [
        {"range": [0, 5], "control_mode": "cartesian_delta", **LEFT},
        {"range": [6, 6], "control_mode": "joint_velocity", "joint_names": ["left_joint3"]},
    ]
    contract = ActionContract.model_validate({"dim": 7, "slots": slots})
    with pytest.raises(ConfigError) as caught:
        resolve_routes(contract, DUAL)
    assert str(caught.value) == (
        "slot [6, 6] joint_velocity: part left_arm is already commanded in cartesian_delta"
    )
