"""Which check enforces each declared limit, in which process, and which test proves it.

What is not listed here is reported as enforced by nothing: a new limit is never taken
for an enforced one. A check that says in words what it does with a limit (``predicts by it``,
``logs and counts it``) does not refuse a value beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead_tools.limits.bound_tests import MODE_TESTS, Enforcement, core_test
from fairlead_tools.limits.check_tests import PROTOCOL_TESTS, proven
from fairlead_tools.limits.effective_limits import EffectiveLimit, effective_limits

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
    "G011 logs and counts it",
    "test_absolute",
    "G011 a passive joint outside its bounds refuses no row; it is counted and said once",
)
_SAID_GRIPPER = core_test(
    "G011 logs and counts it",
    "test_absolute",
    "G011 a gripper beyond its bounds and tolerance is counted and said once",
)
_RECKONS = "predicts by it"
MOST_ABOVE = 1.1
"""Of the effort limit: a contact limit up to here is taken to bound the effort."""


def joint_enforcement(
    limit: str, joint: str, robot: RobotManifest, contact: Value, effort: Value
) -> tuple[Enforcement, ...]:
    """The checks of one limit of one joint, commanded or passive.

    Args:
        contact, effort: the joint's limits of these names, None for a passive joint.
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
        return _of_measured_effort(contact, effort)
    if limit == "velocity_limit":
        return _of_speed(part, "base" if joint in robot.base_joints else "speed")
    if limit in ("acceleration_limit", "stop_lag"):
        return proven("base" if joint in robot.base_joints else "braking", _RECKONS)
    return proven({"contact_limit": "contact", "encoder_step": "stuck"}.get(limit, "dead band"))


def _of_measured_effort(contact: Value, effort: Value) -> tuple[Enforcement, ...]:
    """Contact stops beyond its own limit; that bounds the effort too where it is not far above."""
    if not isinstance(contact, float) or not isinstance(effort, float):
        return ()
    return proven("contact", f"beyond {contact:g}") if contact <= MOST_ABOVE * effort else ()


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
    return (outside, *_absolute(part, "joint_position", "dex_hand_joint"), *proven("braking"))


def _of_speed(part: Part, braking: str) -> tuple[Enforcement, ...]:
    """Per mode: velocities are compared with it, everything else is reckoned to brake from it."""
    told = _absolute(part, "joint_velocity")
    others = [mode for mode in part.modes if mode != "joint_velocity"]
    reckoned = proven(braking, f"{_RECKONS} in {', '.join(others)}") if others else ()
    return (*told, *reckoned)


@dataclass(frozen=True)
class Bound:
    """One declared limit and everything that enforces it; nothing, where it is empty."""

    limit: EffectiveLimit
    enforced_by: tuple[Enforcement, ...]


_BY_NAME = {
    "transitions": "transitions",
    "singularity_limit": "singularity",
    "slip_limit": "slip",
    "switching": "switching",
    "clearance": "clearance",
    "pairs": "pairs",
    "yaw_axis": "yaw axis",
    "footprint": "base",
    "reaction_s": "base",
    "tool_drift": "carried",
    "clearance_drift": "carried",
    "stuck_ticks": "stuck",
    "stop_ramp_ms": "stop ramp",
    "step_deadline_us": "deadline",
}
"""Names in `CHECK_TESTS` of limits that mean the same wherever they stand."""
_ZONES = {"keep_in zone": "base", "keep_out zone": "keep_out zone"}


def robot_bounds(robot: RobotManifest, profile: str = "sim") -> list[Bound]:
    """Every declared limit of a profile: joints, parts, modes, shape, surroundings, protocol.

    Raises:
        ConfigError: if the robot has no such profile.
    """
    limits = effective_limits(robot, profile)
    values = {(limit.where, limit.name): limit.value for limit in limits}
    bounds = []
    for limit in limits:
        kind, *names = limit.where.split()
        if kind == "joint":
            ends = (values.get((limit.where, f"{end}_limit")) for end in ("contact", "effort"))
            by = joint_enforcement(limit.name, names[0], robot, *ends)
        else:
            by = _enforcement(limit, kind, names[1:])
        bounds.append(Bound(limit, by))
    return bounds


def _enforcement(limit: EffectiveLimit, kind: str, modes: list[str]) -> tuple[Enforcement, ...]:
    if limit.name in _BY_NAME:
        return proven(_BY_NAME[limit.name])
    if kind == "protocol":
        return (PROTOCOL_TESTS[limit.name],) if limit.name in PROTOCOL_TESTS else ()
    if kind in ("volume", "zone"):
        place = f"{limit.name.split()[0]} {kind}"
        return proven(_ZONES.get(place, place))
    return _of_mode(limit, modes[0])


def _of_mode(limit: EffectiveLimit, mode: str) -> tuple[Enforcement, ...]:
    if limit.name.endswith("tracking"):
        return proven(f"tracking {mode}")
    if limit.name == "gain":
        reckoned = proven(f"gain {mode}", _RECKONS)
        return (*reckoned, *proven(f"tracking {mode}", _RECKONS))
    if mode not in MODE_TESTS:
        return ()
    tests = MODE_TESTS[mode]
    return (tests.start, tests.step) if limit.name.endswith("step_limit") else (tests.absolute,)
