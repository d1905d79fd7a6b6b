"""Which check enforces each declared limit, in which process, and which test proves it.

What is not listed here is reported as enforced by nothing: a new limit is never taken
for an enforced one. A check that says in words what it does with a limit (``predicts by it``,
``logs and counts it``) does not refuse a value beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.robot.manifest import RobotManifest
from fairlead_tools.limits.bound_tests import MODE_TESTS, Enforcement
from fairlead_tools.limits.check_tests import proven
from fairlead_tools.limits.effective_limit import EffectiveLimit
from fairlead_tools.limits.effective_limits import effective_limits
from fairlead_tools.limits.joint_bounds import joint_enforcement
from fairlead_tools.limits.protocol_tests import PROTOCOL_TESTS


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
_RECKONS = "predicts by it"


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
