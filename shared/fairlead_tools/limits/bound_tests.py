"""The tests that prove the gate's limits mode by mode, by their names in the C++ tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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


def core_test(check: str, file: str, test: str) -> Enforcement:
    """A check of the gate's core, proven by a test in ``file`` (no folder, no suffix)."""
    return Enforcement(check, f"{CORE_TESTS}/{file}.cpp", test)


@dataclass(frozen=True)
class ModeTests:
    """The tests of one mode's limits: of a row itself, of a first row, of the next row."""

    absolute: Enforcement
    start: Enforcement
    step: Enforcement


_ROW_STEP = core_test("G022", "test_steps", "G022 the jump from row to row, for every mode")
_RANGE = core_test(
    "G020", "test_absolute", "G020 gripper and composite: inside their ranges, ends included"
)
_FREE_START = core_test("G021", "test_steps", "G021 a delta or twist after a hold starts from zero")
_KNOWN_START = core_test(
    "G021", "test_steps", "G021 gripper and composite start from what is known of them"
)

MODE_TESTS: Mapping[str, ModeTests] = {
    "joint_position": ModeTests(
        core_test(
            "G020", "test_absolute", "G020 joint position: inside the joint's bounds, ends included"
        ),
        core_test(
            "G021",
            "test_steps",
            "G021 a joint target starts within a step of the measured position",
        ),
        _ROW_STEP,
    ),
    "joint_velocity": ModeTests(
        core_test(
            "G020",
            "test_absolute",
            "G020 joint velocity: up to the joint's limit in both directions",
        ),
        core_test(
            "G021",
            "test_steps",
            "G021 a velocity starts from what was executed, after a hold from what is measured",
        ),
        _ROW_STEP,
    ),
    "cartesian_pose": ModeTests(
        core_test(
            "G020", "test_cartesian_pose", "G020 cartesian pose: inside the box, ends included"
        ),
        core_test(
            "G021",
            "test_cartesian_pose",
            "G021 a pose starts at the measured tool frame and at what was executed",
        ),
        core_test(
            "G022",
            "test_cartesian_pose",
            "G022 cartesian pose: the jump from row to row in place and angle",
        ),
    ),
    "cartesian_delta": ModeTests(
        core_test("G020", "test_absolute", "G020 cartesian delta: the norm counts, not the axes"),
        _FREE_START,
        _ROW_STEP,
    ),
    "cartesian_twist": ModeTests(
        core_test("G020", "test_cartesian_twist", "G020 cartesian twist: the norm of each half"),
        core_test(
            "G021",
            "test_cartesian_twist",
            "G021 a tool twist starts from what was executed, after a hold from what is measured",
        ),
        core_test("G022", "test_cartesian_twist", "G022 cartesian twist: the jump from row to row"),
    ),
    "body_twist": ModeTests(
        core_test("G020", "test_absolute", "G020 body twist: the norm of each half"),
        _FREE_START,
        _ROW_STEP,
    ),
    "gripper_position": ModeTests(_RANGE, _KNOWN_START, _ROW_STEP),
    "dex_hand_joint": ModeTests(
        core_test(
            "G020",
            "test_two_arms",
            "G020 dex hand joint: inside the joint's bounds, ends included",
        ),
        core_test(
            "G021",
            "test_two_arms",
            "G021 dex hand joint: within a step of what is measured and of what was executed",
        ),
        core_test("G022", "test_two_arms", "G022 dex hand joint: the jump from row to row"),
    ),
    "composite_mode": ModeTests(_RANGE, _KNOWN_START, _ROW_STEP),
}
