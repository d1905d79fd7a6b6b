"""The tests that prove the checks of motion, shape, surroundings and the gate itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fairlead_tools.limits.bound_tests import Enforcement, core_test

_TOOL = core_test(
    "G040",
    "test_tracking_tools",
    "G040 deltas and twists: the tool's displacement, along and across what was told",
)
_TARGET = core_test(
    "G040",
    "test_tracking",
    "G040 joint targets: the joint is within the tracking limit of the target that acted",
)

CHECK_TESTS: Mapping[str, Enforcement] = {
    "tracking joint_position": _TARGET,
    "tracking dex_hand_joint": _TARGET,
    "tracking joint_velocity": core_test(
        "G040",
        "test_tracking",
        "G040 joint velocities after a row: between the shares of both, and the slack",
    ),
    "tracking body_twist": core_test(
        "G040",
        "test_tracking",
        "G040 a body twist: the base's displacement along its own axes",
    ),
    "tracking cartesian_delta": _TOOL,
    "tracking cartesian_twist": _TOOL,
    "tracking cartesian_pose": core_test(
        "G040",
        "test_tracking_tools",
        "G040 a pose: distance and angle of the tool from the one that acted",
    ),
    "stuck": core_test(
        "G041",
        "test_stuck",
        "G041 stops after stuck_ticks rows that change nothing beyond the encoder's step",
    ),
    "dead band": core_test(
        "G041",
        "test_stuck",
        "G041 within the dead band nothing has to move; slow rows add up to it",
    ),
    "contact": core_test(
        "G042",
        "test_contact",
        "G042 a commanded joint presses up to its contact limit, of either sign",
    ),
    "slip": core_test(
        "G042",
        "test_contact",
        "G042 a gripper that stood still short of its target loses up to slip_limit",
    ),
    "transitions": core_test(
        "G025",
        "test_transitions",
        "G025 after arming any mode may start; then only those that may follow it",
    ),
    "switching": core_test(
        "G025",
        "test_composite_switch",
        "G025 the switch turns while every part of the claim stands still",
    ),
    "stop ramp": core_test(
        "G043",
        "test_stop_ramp",
        "G043 not at standstill at the end of the ramp: latched, naming the joint",
    ),
    "deadline": core_test(
        "G050",
        "test_gate_itself",
        "G050 the third step over its deadline within 60 s stops, at the deadline none does",
    ),
    "braking": core_test(
        "G024",
        "test_braking",
        "G024 a target: the row's change over the period, and the way it takes to brake",
    ),
    "speed": core_test(
        "G024",
        "test_braking",
        "G024 no joint is faster than its limit, whatever a target asks for",
    ),
    "gain joint_velocity": core_test(
        "G024",
        "test_braking",
        "G024 velocities: the share that the gain says, and the limit of the joint",
    ),
    "gain cartesian_delta": core_test(
        "G024", "test_braking", "G024 a delta brakes like the joints that it moves"
    ),
    "gain cartesian_twist": core_test(
        "G033", "test_singularity", "G033 twists, by their period; and where braking ends"
    ),
    "keep_in volume": core_test(
        "G031", "test_workspace", "G031 the tool stays in: each face, up to and including it"
    ),
    "keep_out volume": core_test("G031", "test_workspace", "G031 the tool stays out"),
    "clearance": core_test(
        "G032", "test_self_collision", "G032 the clearance, up to and including it"
    ),
    "pairs": core_test(
        "G032",
        "test_self_collision",
        "G032 only pairs that are declared, and only what the chunk moves",
    ),
    "singularity": core_test(
        "G033", "test_singularity", "G033 the smallest singular value, from above"
    ),
    "base": core_test(
        "G034",
        "test_zones",
        "G034 every corner stays inside: the row, the reaction, and braking",
    ),
    "carried": core_test(
        "G031",
        "test_carried",
        "G031 a base that drives: a tool it carries keeps its drift from the edge",
    ),
    "yaw axis": core_test(
        "G034", "test_zones", "G034 a turn swings the corners out, about the yaw axis"
    ),
    "keep_out zone": core_test(
        "G034", "test_zones", "G034 a keep-out zone is not touched, not even by an edge"
    ),
}
"""What is proven, by a name of its own; what is not here is taken for enforced by nothing."""


def proven(name: str, words: str = "") -> tuple[Enforcement, ...]:
    """The check of that name, with what it does in words where it does not simply compare."""
    if name not in CHECK_TESTS:
        return ()
    found = CHECK_TESTS[name]
    return (replace(found, check=f"{found.check} {words}".rstrip()),)


_HEARTBEAT = core_test(
    "end of the claim",
    "test_candidates",
    "heartbeats keep a claim, their loss ends it, and only its own source's count",
)
PROTOCOL_TESTS: Mapping[str, Enforcement] = {
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
        "disarming", "test_arming", "armed without a claim for 30 s disarms, in lockstep too"
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
        "G001 bad frames far apart, on another key, or that do not cite it leave the claim alone",
    ),
    "second_person_s": core_test(
        "latch", "test_latch", "where two persons are asked for, one alone does not reset a latch"
    ),
}
