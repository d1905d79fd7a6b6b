"""The tests that prove the checks of motion, shape, surroundings and the gate itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fairlead.robot.bound_tests import Enforcement, core_test

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
    "dead band": core_test("G041", "test_stuck", "G041 motion within the dead band proves nothing"),
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
}
"""What is proven, by a name of its own; what is not here is taken for enforced by nothing."""


def proven(name: str, words: str = "") -> tuple[Enforcement, ...]:
    """The check of that name, with what it does in words where it does not simply compare."""
    if name not in CHECK_TESTS:
        return ()
    found = CHECK_TESTS[name]
    return (replace(found, check=f"{found.check} {words}".rstrip()),)
