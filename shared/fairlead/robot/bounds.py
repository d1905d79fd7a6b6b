"""Which check enforces each declared limit, in which process, and which test proves it.

What is not listed here is reported as enforced by nothing: a new limit is never taken
for an enforced one. A check that says in words what it does with a limit (``reckons with it``,
``says and counts it``) does not refuse a value beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.robot.bound_tests import MODE_TESTS, Enforcement
from fairlead.robot.check_tests import proven
from fairlead.robot.effective_limit import EffectiveLimit
from fairlead.robot.joint_bounds import joint_enforcement
from fairlead.robot.limits import effective_limits
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.protocol_tests import PROTOCOL_TESTS


@dataclass(frozen=True)
class Bound:
    """One declared limit and everything that enforces it; nothing, where it is empty."""

    limit: EffectiveLimit
    enforced_by: tuple[Enforcement, ...]


_OF_PART = {"transitions": "G025", "singularity_limit": "G033"}
_OF_MODE = {"slip_limit": "G042", "switching": "G025"}
_AROUND = {"self-collision": "G032", "volume": "G031", "base": "G034", "zone": "G034"}
_PREDICTED = "reckons with it"


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
            contact = values.get((limit.where, "contact_limit"))
            effort = values.get((limit.where, "effort_limit"))
            by = joint_enforcement(limit.name, names[0], robot, contact, effort)
        else:
            by = _enforcement(limit, kind, names[1:], robot)
        bounds.append(Bound(limit, by))
    return bounds


def _enforcement(
    limit: EffectiveLimit, kind: str, modes: list[str], robot: RobotManifest
) -> tuple[Enforcement, ...]:
    if kind == "protocol":
        return (PROTOCOL_TESTS[limit.name],) if limit.name in PROTOCOL_TESTS else ()
    if kind in _AROUND:
        return proven(_AROUND[kind])
    if not modes:
        return proven(_OF_PART[limit.name])
    return _of_mode(limit, modes[0], robot)


def _of_mode(limit: EffectiveLimit, mode: str, robot: RobotManifest) -> tuple[Enforcement, ...]:
    if limit.name in _OF_MODE:
        return proven(_OF_MODE[limit.name])
    if limit.name.endswith("tracking"):
        return proven("G040")
    if limit.name == "gain":
        part = robot.part(limit.where.split()[1])
        on_base = set(part.joints) & set(robot.base_joints)
        return (*proven("G034" if on_base else "G024", _PREDICTED), *proven("G040"))
    if mode not in MODE_TESTS:
        return ()
    tests = MODE_TESTS[mode]
    return (tests.start, tests.step) if limit.name.endswith("step_limit") else (tests.absolute,)
