"""Which check enforces each declared limit, in which process, and which test proves it.

What is not listed here is reported as enforced by nothing: a new limit is never taken
for an enforced one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from fairlead.gate_config import compile_gate_config
from fairlead.robot import RobotManifest
from fairlead.robot_limits import EffectiveLimit, effective_limits

CORE_TESTS = "services/safety/test/core"
GATE = "safety"


@dataclass(frozen=True)
class Enforcement:
    """One check.

    Attributes:
        check: its code, or in words what the limit decides.
        file: test file, from the root of the checkout.
        test: the test's name in that file.
        process: the kind of service that enforces it.
    """

    check: str
    file: str
    test: str
    process: str = GATE


@dataclass(frozen=True)
class Bound:
    """One declared limit and everything that enforces it; nothing, where it is empty."""

    limit: EffectiveLimit
    enforced_by: tuple[Enforcement, ...]


def _core(check: str, file: str, test: str) -> Enforcement:
    return Enforcement(check, f"{CORE_TESTS}/{file}.cpp", test)


_OUTSIDE = "G011 an arm joint outside bounds and tolerance: only targets nearer to them"
_POSITION = _core(
    "G020", "test_absolute", "G020 joint position: inside the joint's bounds, ends included"
)
_VELOCITY = _core(
    "G020", "test_absolute", "G020 joint velocity: up to the joint's limit in both directions"
)
_JUMP = _core(
    "G013",
    "test_stops",
    "G013 a measured jump stops; what the robot can do in the ticks between does not",
)
_STANDSTILL = _core(
    "reset of a latch",
    "test_latch",
    "a latch is reset by its id, at standstill, after ten good states, to disarmed",
)
_ROW_STEP = _core("G022", "test_steps", "G022 the jump from row to row, for every mode")

_DELTA_NORM = _core("G020", "test_absolute", "G020 cartesian delta: the norm counts, not the axes")
_TWIST_NORM = _core("G020", "test_absolute", "G020 body twist: the norm of each half")
_RANGE = _core(
    "G020", "test_absolute", "G020 gripper and composite: inside their ranges, ends included"
)
_ABSOLUTE = {
    "cartesian_delta": _DELTA_NORM,
    "body_twist": _TWIST_NORM,
    "gripper_position": _RANGE,
}
_FREE_START = "G021 a delta or twist after a hold starts from zero"
_KNOWN_START = "G021 gripper and composite start from what is known of them"
_FIRST_STEP = {
    "joint_position": "G021 a joint target starts within a step of the measured position",
    "joint_velocity": (
        "G021 a velocity starts from what was executed, after a hold from what is measured"
    ),
    "cartesian_delta": _FREE_START,
    "body_twist": _FREE_START,
    "gripper_position": _KNOWN_START,
    "composite_mode": _KNOWN_START,
}

_HEARTBEAT = _core(
    "end of the claim",
    "test_candidates",
    "heartbeats keep a claim, their loss ends it, and only its own source's count",
)
_PROTOCOL: Mapping[str, Enforcement] = {
    "horizon_max": _core(
        "G007", "test_shape", "G007 the horizon lies between 1 and the claim's maximum"
    ),
    "age_max_ticks": _core(
        "G006",
        "test_ticks",
        "G006 ages at the limit, beyond it, and inputs newer than the observation",
    ),
    "chunk_rate_max_hz": _core(
        "G010",
        "test_ticks",
        "G010 the excess over the declared rate is refused, counted in ticks",
    ),
    "seq_jump_max": _core(
        "G005", "test_candidates", "G005 seq is strictly increasing and jumps at most 1,000"
    ),
    "state_timeout_ms": _core(
        "G011", "test_stops", "G011 no new state for 250 ms stops an armed gate in realtime"
    ),
    "heartbeat_timeout_realtime_ms": _HEARTBEAT,
    "heartbeat_timeout_lockstep_ms": _HEARTBEAT,
    "lease_interval_ms": _core(
        "leases", "test_arming", "leases come with every state and at least every 25 ms"
    ),
    "idle_disarm_s": _core(
        "disarming", "test_arming", "armed without a claim for 30 s disarms, in realtime only"
    ),
    "stops_to_latch": _core(
        "latch", "test_latch", "three stops of the gate's own within 60 s of ticks latch"
    ),
    "stop_window_s": _core(
        "latch",
        "test_latch",
        "stops spread wider than the window do not latch, nor do an operator's",
    ),
    "bad_frames_limit": _core(
        "G001",
        "test_candidates",
        "G001 an unreadable frame is refused; five in 20 ticks end the claim",
    ),
    "bad_frames_window_ticks": _core(
        "G001",
        "test_candidates",
        "G001 bad frames far apart, or on another key, leave the claim alone",
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
    by_limit: dict[str, tuple[Enforcement, ...]] = {
        "lower": (*measured, _POSITION) if "joint_position" in modes else measured,
        "tolerance": measured,
        "jump_limit": (_JUMP,),
        "standstill_velocity": (_STANDSTILL,),
        "velocity_limit": (_VELOCITY,) if "joint_velocity" in modes else (),
    }
    return by_limit.get("lower" if limit == "upper" else limit, ())


def _measured_bounds(joint: str, robot: RobotManifest, modes: list[str]) -> tuple[Enforcement, ...]:
    """Only what refuses something counts.

    Nothing brings a passive joint back, so no row is refused for it; a gripper's target is
    judged by its mode's own range.
    """
    if joint in robot.passive_joint_names or set(modes) <= {"gripper_position"}:
        return ()
    return (_core("G011", "test_absolute", _OUTSIDE),)


def _of_mode(limit: str, mode: str) -> tuple[Enforcement, ...]:
    if mode not in _FIRST_STEP:
        return ()
    if limit.endswith("step_limit"):
        return (_core("G021", "test_steps", _FIRST_STEP[mode]), _ROW_STEP)
    return (_ABSOLUTE[mode],) if mode in _ABSOLUTE else ()


def _protocol_bounds(robot: RobotManifest, profile: str) -> list[Bound]:
    protocol: dict[str, float] = json.loads(compile_gate_config(robot, profile))["protocol"]
    bounds = []
    for name, value in protocol.items():
        unit = name.rsplit("_", 1)[-1]
        unit = unit if unit in ("ms", "s", "hz", "ticks") else "1"
        limit = EffectiveLimit("protocol", name, float(value), unit, "robot.yaml, safety.protocol")
        bounds.append(Bound(limit, (_PROTOCOL[name],) if name in _PROTOCOL else ()))
    return bounds
