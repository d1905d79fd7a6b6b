"""Which check enforces each declared limit, in which process, and which test proves it.

What is not listed here is reported as enforced by nothing: a new limit is never taken
for an enforced one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from fairlead.robot.bound_tests import MODE_TESTS, Enforcement, core_test
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.limits import EffectiveLimit, effective_limits
from fairlead.robot.manifest import RobotManifest


@dataclass(frozen=True)
class Bound:
    """One declared limit and everything that enforces it; nothing, where it is empty."""

    limit: EffectiveLimit
    enforced_by: tuple[Enforcement, ...]


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

_HEARTBEAT = core_test(
    "end of the claim",
    "test_candidates",
    "heartbeats keep a claim, their loss ends it, and only its own source's count",
)
_PROTOCOL: Mapping[str, Enforcement] = {
    "horizon_max": core_test(
        "G007", "test_shape", "G007 the horizon lies between 1 and the claim's maximum"
    ),
    "age_max_ticks": core_test(
        "G006",
        "test_ticks",
        "G006 ages at the limit, beyond it, and inputs newer than the observation",
    ),
    "chunk_rate_max_hz": core_test(
        "G010",
        "test_ticks",
        "G010 the excess over the declared rate is refused, counted in ticks",
    ),
    "seq_jump_max": core_test(
        "G005", "test_candidates", "G005 seq is strictly increasing and jumps at most 1,000"
    ),
    "state_timeout_ms": core_test(
        "G011", "test_stops", "G011 no new state for 250 ms stops an armed gate in realtime"
    ),
    "heartbeat_timeout_realtime_ms": _HEARTBEAT,
    "heartbeat_timeout_lockstep_ms": _HEARTBEAT,
    "lease_interval_ms": core_test(
        "leases", "test_arming", "leases come with every state and at least every 25 ms"
    ),
    "idle_disarm_s": core_test(
        "disarming", "test_arming", "armed without a claim for 30 s disarms, in realtime only"
    ),
    "stops_to_latch": core_test(
        "latch", "test_latch", "three stops of the gate's own within 60 s of ticks latch"
    ),
    "stop_window_s": core_test(
        "latch",
        "test_latch",
        "stops spread wider than the window do not latch, nor do an operator's",
    ),
    "bad_frames_limit": core_test(
        "G001",
        "test_candidates",
        "G001 an unreadable frame is refused; five in 20 ticks end the claim",
    ),
    "bad_frames_window_ticks": core_test(
        "G001",
        "test_candidates",
        "G001 bad frames far apart, or on another key, leave the claim alone",
    ),
    "stop_ramp_ms": core_test(
        "G043",
        "test_stop_ramp",
        "G043 not at standstill at the end of the ramp: latched, naming the joint",
    ),
    "step_deadline_us": core_test(
        "G050",
        "test_gate_itself",
        "G050 the third step over its deadline within 60 s stops, at the deadline none does",
    ),
}


def robot_bounds(robot: RobotManifest, profile: str = "sim") -> list[Bound]:
    """Every declared limit of a profile: joints, zones, modes of parts, protocol.

    Raises:
        ConfigError: if the robot has no such profile.
    """
    limits = effective_limits(robot, profile)
    bounds = [Bound(limit, _enforced_by(limit, robot)) for limit in limits]
    bounds += [Bound(_zone(joint.name), ()) for joint in robot.joints if not joint.has_bounds]
    return bounds + _protocol_bounds(robot, profile)


def _zone(joint: str) -> EffectiveLimit:
    return EffectiveLimit(f"joint {joint}", "zones", (), "", "robot.yaml: bounded_by zones")


def _enforced_by(limit: EffectiveLimit, robot: RobotManifest) -> tuple[Enforcement, ...]:
    what, name, *mode = limit.where.split()
    if what == "joint":
        return _of_joint(limit.name, name, robot)
    return _of_mode(limit.name, mode[0])


def _of_joint(limit: str, joint: str, robot: RobotManifest) -> tuple[Enforcement, ...]:
    modes = [mode for part in robot.parts if joint in part.joints for mode in part.modes]
    measured = _measured_bounds(joint, robot, modes)
    targets = _absolute(modes, "joint_position", "dex_hand_joint")
    by_limit: dict[str, tuple[Enforcement, ...]] = {
        "lower": (*measured, *targets),
        "upper": (*measured, *targets),
        "tolerance": measured,
        "jump_limit": (_JUMP,),
        "standstill_velocity": (_STANDSTILL,),
        "velocity_limit": _absolute(modes, "joint_velocity"),
        "effort_limit": _absolute(modes, "joint_torque"),
    }
    return by_limit.get(limit, ())


def _absolute(modes: list[str], *judging: str) -> tuple[Enforcement, ...]:
    """The checks of rows by the joint's own limit, in those modes its part has."""
    return tuple(MODE_TESTS[mode].absolute for mode in judging if mode in modes)


def _measured_bounds(joint: str, robot: RobotManifest, modes: list[str]) -> tuple[Enforcement, ...]:
    """Only what refuses something counts.

    Nothing brings a passive joint back, so no row is refused for it; a gripper's target is
    judged by its mode's own range.
    """
    if joint in robot.passive_joint_names or set(modes) <= {"gripper_position", "gripper_binary"}:
        return ()
    return (_OUTSIDE_HAND if modes == ["dex_hand_joint"] else _OUTSIDE,)


def _of_mode(limit: str, mode: str) -> tuple[Enforcement, ...]:
    if mode not in MODE_TESTS:
        return ()
    tests = MODE_TESTS[mode]
    return (tests.start, tests.step) if limit.endswith("step_limit") else (tests.absolute,)


def _protocol_bounds(robot: RobotManifest, profile: str) -> list[Bound]:
    protocol: dict[str, float] = json.loads(compile_gate_config(robot, profile))["protocol"]
    bounds = []
    for name, value in protocol.items():
        unit = name.rsplit("_", 1)[-1]
        unit = unit if unit in ("ms", "s", "hz", "ticks") else "1"
        limit = EffectiveLimit("protocol", name, float(value), unit, "robot.yaml, safety.protocol")
        bounds.append(Bound(limit, (_PROTOCOL[name],) if name in _PROTOCOL else ()))
    return bounds
