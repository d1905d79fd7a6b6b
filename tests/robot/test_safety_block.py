"""The safety block of robot.yaml: the full text of every refusal."""

from pathlib import Path
from typing import Any

from tests.robot.refused import refusal, top


def test_mode_the_gate_cannot_check_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][0]["modes"].append("joint_trajectory")
    assert refusal(data, tmp_path) == top(
        "safety.sim: part 'arm': the gate has no checker for joint_trajectory"
    )


def test_mode_without_limits_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["parts"]["base"]["body_twist"]
    assert refusal(data, tmp_path) == top("safety.sim: part 'base' modes: missing body_twist")


def test_limits_for_a_mode_the_part_lacks_are_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["parts"][2]["modes"] = ["joint_velocity"]
    assert refusal(data, tmp_path) == top(
        "safety.sim: part 'base' modes: unknown body_twist (valid: joint_velocity)"
    )


def test_measured_limits_must_cover_every_joint(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["measured"]["torso_height"]
    assert refusal(data, tmp_path) == top("safety.sim: measured: missing torso_height")


def test_tolerance_goes_with_position_limits(data: dict[str, Any], tmp_path: Path) -> None:
    del data["safety"]["sim"]["measured"]["panda_joint1"]["tolerance"]
    data["safety"]["sim"]["measured"]["base_yaw"]["tolerance"] = 0.1
    assert refusal(data, tmp_path) == (
        "2 problem(s):\n  safety.sim: measured: joint 'base_yaw': tolerance is given "
        "for a joint without position limits\n"
        "  safety.sim: measured: joint 'panda_joint1': tolerance is missing"
    )


def test_step_limits_of_the_wrong_width_are_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["safety"]["sim"]["parts"]["base"]["joint_velocity"]["step_limits"] = [2.0, 2.0]
    assert refusal(data, tmp_path) == top(
        "safety.sim: part 'base': step_limits: expected one per joint, 3, got 2"
    )


def test_a_deadline_that_states_grow_too_old_before_is_refused(
    data: dict[str, Any], tmp_path: Path
) -> None:
    data["safety"]["sim"]["protocol"] |= {"step_deadline_us": 250_000, "state_timeout_ms": 250}
    assert refusal(data, tmp_path) == top(
        "safety.sim: protocol: step_deadline_us: expected less than state_timeout_ms, 250000 us,"
        " got 250000"
    )


def test_inverted_gripper_range_is_refused(data: dict[str, Any], tmp_path: Path) -> None:
    data["safety"]["sim"]["parts"]["gripper"]["gripper_position"]["upper_m"] = -0.01
    assert refusal(data, tmp_path) == (
        "1 problem(s):\n  safety.sim.parts.gripper.gripper_position: "
        "gripper_position: inverted limits, lower_m 0.0 is not below upper_m -0.01"
    )
