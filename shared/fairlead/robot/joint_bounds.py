"""What enforces the limits of one joint: it depends on the modes of the part that has it."""

from __future__ import annotations

from fairlead.robot.bound_tests import MODE_TESTS, Enforcement, core_test
from fairlead.robot.check_tests import proven
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part

Value = float | tuple[float, ...] | str | None

_JUMP = core_test(
    "G013",
    "test_stops",
    "G013 a measured jump stops; what the robot can do in the ticks between does not",
)
_STANDSTILL = core_test(
    "reset of a latch",
    "test_latch",
    "a latch is reset by its id, at standstill, after ten good states, to disarmed",
)
_OUTSIDE = core_test(
    "G011",
    "test_absolute",
    "G011 an arm joint outside bounds and tolerance: only targets nearer to them",
)
_OUTSIDE_HAND = core_test(
    "G011",
    "test_two_arms",
    "G011 dex hand joint: a finger outside its bounds may only come back",
)
_SAID_PASSIVE = core_test(
    "G011 says and counts it",
    "test_absolute",
    "G011 a passive joint outside its bounds refuses no row; it is counted and said once",
)
_SAID_GRIPPER = core_test(
    "G011 says and counts it",
    "test_absolute",
    "G011 a gripper beyond its bounds and tolerance is counted and said once",
)
_FAST_TORQUE = core_test(
    "G021 in joint_torque",
    "test_joint_torque",
    "G021 joint torque: no row while a commanded joint is above its velocity limit",
)
_PREDICTED = "reckons with it"


def joint_enforcement(
    limit: str, joint: str, robot: RobotManifest, contact: Value, effort: Value
) -> tuple[Enforcement, ...]:
    """The checks of one limit of one joint, commanded or passive.

    Args:
        contact, effort: the joint's limits of these names, None for a passive joint. Where
            contact lies at or below effort, no measured effort beyond either passes.
    """
    common = {"jump_limit": (_JUMP,), "standstill_velocity": (_STANDSTILL,)}
    if limit in common:
        return common[limit]
    if joint in robot.passive_joint_names:
        return (_SAID_PASSIVE,) if limit in ("lower", "upper", "tolerance") else ()
    part = robot.owner(joint)
    if limit in ("lower", "upper", "tolerance"):
        return _of_range(limit, part)
    if limit == "effort_limit":
        caught = isinstance(contact, float) and isinstance(effort, float) and contact <= effort
        return (*_absolute(part, "joint_torque"), *(proven("G042") if caught else ()))
    if limit == "velocity_limit":
        return _of_speed(part, _braking_check(joint, robot))
    if limit == "acceleration_limit":
        return proven(_braking_check(joint, robot), _PREDICTED)
    return proven({"contact_limit": "G042", "encoder_step": "G041", "dead_band": "G041"}[limit])


def _braking_check(joint: str, robot: RobotManifest) -> str:
    return "G034" if joint in robot.base_joints else "G024"


def _absolute(part: Part, *judging: str) -> tuple[Enforcement, ...]:
    """The checks of rows by the joint's own limit, in those modes its part has."""
    return tuple(MODE_TESTS[mode].absolute for mode in judging if mode in part.modes)


def _of_range(limit: str, part: Part) -> tuple[Enforcement, ...]:
    """A gripper's openings lie inside its joint's bounds, or no gate starts."""
    if part.only_grips:
        told = _absolute(part, "gripper_position") if limit != "tolerance" else ()
        return (_SAID_GRIPPER, *told)
    outside = _OUTSIDE_HAND if part.modes == ("dex_hand_joint",) else _OUTSIDE
    if limit == "tolerance":
        return (outside,)
    return (outside, *_absolute(part, "joint_position", "dex_hand_joint"), *proven("G024"))


def _of_speed(part: Part, braking: str) -> tuple[Enforcement, ...]:
    """Per mode: velocities are compared with it, everything else is reckoned to brake from it."""
    told = _absolute(part, "joint_velocity")
    torque = (_FAST_TORQUE,) if "joint_torque" in part.modes else ()
    others = [mode for mode in part.modes if mode not in ("joint_velocity", "joint_torque")]
    reckoned = proven(braking, f"{_PREDICTED} in {', '.join(others)}") if others else ()
    return (*told, *torque, *reckoned)
