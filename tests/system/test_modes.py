"""Every control mode from a skill's numbers to what the arms do, and refused above a limit.

Each skill says one row of numbers that differ in size and sign, so that a swapped order, a
wrong unit, sign or frame shows in what the HAL gets (to the bit) and in what the robot does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.robot.manifest import load_robot
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.system.mode_robot import ModeRobot, ModeSkill, Story, write_skills
from tests.system.tool_geometry import ToolGeometry

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "dual_panda_mujoco.yaml"
ROBOT = load_robot("dual_panda")
N = ROBOT.n_dof
PARTS = {name: index for index, name in enumerate(ROBOT.part_names)}
LEFT, RIGHT = [f"left_joint{k}" for k in range(1, 8)], [f"right_joint{k}" for k in range(1, 8)]
HAND = list(ROBOT.part("right_hand").joints)
HOME = dict(zip(
    [*LEFT, *RIGHT, *HAND],
    [0, -0.3, 0, -2.2, 0, 2.0, 0.785, 0.1, -0.4, 0.1, -2.1, 0.1, 1.9, 0.6,
     0.3, 0.5, 0.4, 0.6, 0.5, 0.7],
    strict=True,
))  # fmt: skip
OPENING = 0.06
STATE = {
    "dim": 14, "joints": [{"names": [*LEFT, *RIGHT], "quantity": "position", "unit": "deg"}],
}  # fmt: skip
SEVEN = (0.05, -0.06, 0.07, -0.08, 0.09, -0.1, 0.04)
SHIFT, TURN = (0.01, -0.02, 0.03), (0.02, -0.04, 0.06)
"""Of the pose, from where the tool is [m, rad]."""
HALVES = (0.5, -0.25, 0.75, 0.25, -0.5, 0.875)
"""Exact in float32, so that scale times number is what the wire must have."""
DELTA_SCALE, TWIST_SCALE = (0.01, 0.028, 0.004, 0.03, 0.01, 0.02), (0.2, 0.56, 0.08, 0.6, 0.2, 0.4)
STILL = 5e-4
"""m or rad: what a part without a command is shaken by one that moves."""
ARRIVED = 1.5e-3
"""m or rad: what is left of a way at standstill velocity (0.02 rad/s, 62 ms behind)."""


GEOMETRY = ToolGeometry(ROBOT)
START = np.array([HOME.get(name, OPENING) for name in ROBOT.joint_names] + [0.03, -0.03])


def pose_numbers(frame: str, shift: tuple[float, ...], turn: tuple[float, ...]) -> list[float]:
    """A pose near the one at home: xyz and quaternion xyzw."""
    home = GEOMETRY.tool(START, frame)
    xyzw = pin.Quaternion(pin.exp3(np.array(turn)) @ home.rotation).coeffs()
    return [*(home.translation + np.array(shift)), *xyzw]


def slot(mode: str, **fields: Any) -> dict[str, Any]:
    return {"control_mode": mode, **fields}


def tool_slot(mode: str, side: str, **fields: Any) -> dict[str, Any]:
    return slot(mode, ee=f"{side}_tool", frame="base_link", **fields)


def joint_slot(mode: str, names: list[str], **fields: Any) -> dict[str, Any]:
    return slot(mode, joint_names=names, **fields)


def skill(slot: dict[str, Any], numbers: Any, ticks: int = 8) -> ModeSkill:
    return ModeSkill((slot,), (tuple(numbers),), ticks)


BOTH = (
    tool_slot("cartesian_twist", "right", scale=list(TWIST_SCALE)),
    slot("gripper_binary", ee="left_tool", threshold=0.0),
    tool_slot("cartesian_delta", "left", scale=list(DELTA_SCALE)),
    joint_slot("dex_hand_joint", HAND),
)
BENT = tuple(HOME[name] + change for name, change in zip(HAND, SEVEN, strict=False))

RELEASED = {
    # joints in the policy's own order, backwards, and in degrees
    "joint-position": skill(
        joint_slot("joint_position", LEFT[::-1], unit="deg"),
        [math.degrees(HOME[name] + change) for name, change in zip(LEFT, SEVEN, strict=True)][::-1],
    ),
    "joint-velocity": skill(
        joint_slot("joint_velocity", RIGHT[::-1], scale=[0.4] * 7), [0.125, *HALVES][::-1]
    ),
    "cartesian-pose": skill(
        tool_slot("cartesian_pose", "left"), pose_numbers("left_tcp", SHIFT, TURN)
    ),
    "cartesian-delta": skill(
        tool_slot("cartesian_delta", "right", scale=list(DELTA_SCALE)), HALVES
    ),
    "cartesian-twist": skill(tool_slot("cartesian_twist", "left", scale=list(TWIST_SCALE)), HALVES),
    "gripper-closed": skill(slot("gripper_binary", ee="left_tool", threshold=0.125), [0.25]),
    "gripper-open": skill(slot("gripper_binary", ee="left_tool", threshold=0.125), [-0.5]),
    "gripper-position": skill(
        slot("gripper_position", ee="left_tool", scale=0.04, offset=0.04), [-0.25]
    ),
    "dex-hand": skill(joint_slot("dex_hand_joint", HAND[::-1]), BENT[::-1]),
    "both-arms": ModeSkill(BOTH, (HALVES, (0.5,), HALVES, BENT)),
}

Refusal = tuple[ModeSkill, int, str, str, float, float]
"""Skill, then of the verdict: code, part, axis, value, limit."""
SPREAD = 3.0**-0.5  # of a norm, on each of three axes


def refused(part: str, slot: dict[str, Any], numbers: Any, code: int, axis: str, value: float,
            limit: float) -> Refusal:  # fmt: skip
    return skill(slot, numbers, ticks=3), code, part, axis, value, limit


def thrice(number: float) -> list[float]:
    return [number, -number, number, 0.0, 0.0, 0.0]


REFUSED: dict[str, Refusal] = {
    "joint-position-limit": refused(
        "left_arm", joint_slot("joint_position", ["left_joint6"]), [3.7526],
        20, "left_joint6", 3.7526, 3.7525),
    "joint-velocity-limit": refused(
        "right_arm", joint_slot("joint_velocity", ["right_joint5"], scale=2.61), [-1.001],
        20, "right_joint5", -2.61261, -2.61),
    "cartesian-pose-box": refused(
        "left_arm", tool_slot("cartesian_pose", "left"), [0.5, 1.001, 0.9, 0, 0, 0, 1],
        20, "y", 1.001, 1.0),
    "cartesian-pose-step": refused(
        "right_arm", tool_slot("cartesian_pose", "right"),
        pose_numbers("right_tcp", (0.0, 0.0505, 0.0), (0.0, 0.0, 0.0)),
        21, "linear", 0.0505, 0.05),
    "cartesian-delta-limit": refused(
        "right_arm", tool_slot("cartesian_delta", "right", scale=0.05 * SPREAD), thrice(1.001),
        20, "linear", 0.05005, 0.05),
    "cartesian-twist-limit": refused(
        "left_arm", tool_slot("cartesian_twist", "left", scale=SPREAD), thrice(-1.001),
        20, "linear", 1.001, 1.0),
    "cartesian-twist-step": refused(
        "left_arm", tool_slot("cartesian_twist", "left", scale=SPREAD), thrice(0.651),
        21, "linear", 0.651, 0.65),
    "gripper-between": refused(
        "left_gripper", slot("gripper_binary", ee="left_tool"), [0.001],
        20, "closed", 0.001, 0.0),
    "gripper-position-limit": refused(
        "left_gripper", slot("gripper_position", ee="left_tool", scale=0.04, offset=0.04),
        [1.0025], 20, "opening", 0.0801, 0.08),
    "dex-hand-limit": refused(
        "right_hand", joint_slot("dex_hand_joint", ["right_thumb_joint1"]), [1.201],
        20, "right_thumb_joint1", 1.201, 1.2),
    "dex-hand-step": refused(
        "right_hand", joint_slot("dex_hand_joint", ["right_index_joint2"]), [0.6 - 0.1905],
        21, "right_index_joint2", 0.1905, 0.19),  # the step and the joint's tolerance
    "one-arm-of-two": (
        ModeSkill(BOTH, (HALVES, (0.5,), HALVES, (1.201, *BENT[1:])), ticks=3),
        20, "right_hand", "right_thumb_joint1", 1.201, 1.2),
}  # fmt: skip


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModeRobot]:
    """One deployment for every skill, on its own ports."""
    folder = tmp_path_factory.mktemp("modes")
    skills = RELEASED | {name: refusal[0] for name, refusal in REFUSED.items()}
    write_skills(folder / "rskills", skills, ROBOT, STATE)
    options: dict[str, dict[str, Any]] = {
        "hal": {"start_spread_rad": 0.0},
        "runner": {"skills": list(skills)},
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SKILLS_VARIABLE, str(folder / "rskills"))
        scratch = make_scratch(SOURCE, folder / "state", ScratchOptions(options=options))
        with scratch_robot(scratch, Registry(folder / "registry")) as running:
            yield ModeRobot(running, skills)


def joints_row(values: dict[str, float]) -> FloatArray:
    """What the wire must have: as wide as the robot, 0.0 wherever no joint is named."""
    row = np.zeros(N)
    for name, value in values.items():
        row[ROBOT.joint_names.index(name)] = value
    return row


def mask(names: list[str]) -> tuple[int, ...]:
    return tuple(sorted(ROBOT.joint_names.index(name) for name in names))


def moved(story: Story, names: list[str]) -> FloatArray:
    """How far these joints are from where they were."""
    own = [ROBOT.joint_names.index(name) for name in names]
    return (story.end - story.start)[own]


def others_are_still(story: Story, *moving: str) -> None:
    """Joints of no named part moved."""
    free = {name for part in moving for name in ROBOT.part(part).joints}
    names = [name for name in ROBOT.joint_names if name not in free]
    assert np.abs(moved(story, names)).max() < STILL


def exact(numbers: tuple[float, ...] | list[float]) -> FloatArray:
    """The numbers as a policy emits them: float32, then widened."""
    return np.array(numbers, dtype=np.float32).astype(np.float64)


def test_joint_position_arrives_where_each_joint_was_sent(robot: ModeRobot) -> None:
    story = robot.run("joint-position")
    degrees = [math.degrees(HOME[name] + by) for name, by in zip(LEFT, SEVEN, strict=True)]
    target = exact(degrees) * (math.pi / 180.0)
    mode, frame, row, active = story.row(PARTS["left_arm"])
    assert (mode, frame, active) == (ControlMode.JOINT_POSITION, "", mask(LEFT))
    np.testing.assert_array_equal(row, joints_row(dict(zip(LEFT, target, strict=True))))
    np.testing.assert_allclose(moved(story, LEFT), SEVEN, rtol=0, atol=ARRIVED)
    others_are_still(story, "left_arm")


def test_joint_velocity_moves_each_joint_at_its_rate(robot: ModeRobot) -> None:
    story = robot.run("joint-velocity")
    rates = np.array([0.125, *HALVES]) * 0.4
    mode, frame, row, active = story.row(PARTS["right_arm"])
    assert (mode, frame, active) == (ControlMode.JOINT_VELOCITY, "", mask(RIGHT))
    np.testing.assert_array_equal(row, joints_row(dict(zip(RIGHT, rates, strict=True))))
    seconds = 0.05 * len(story.acted(PARTS["right_arm"]))
    assert seconds > 0.3
    np.testing.assert_allclose(moved(story, RIGHT), rates * seconds, rtol=0, atol=ARRIVED)
    others_are_still(story, "right_arm")


def test_cartesian_pose_is_where_the_tool_comes_to_rest(robot: ModeRobot) -> None:
    story = robot.run("cartesian-pose")
    mode, frame, row, active = story.row(PARTS["left_arm"])
    assert (mode, frame, active) == (ControlMode.CARTESIAN_POSE, "base_link", ())
    np.testing.assert_array_equal(row, exact(pose_numbers("left_tcp", SHIFT, TURN)))
    shift, turn = GEOMETRY.moved(story, "left_tcp")
    np.testing.assert_allclose(shift, SHIFT, rtol=0, atol=ARRIVED)
    np.testing.assert_allclose(turn, TURN, rtol=0, atol=ARRIVED)
    others_are_still(story, "left_arm")


@pytest.mark.parametrize(
    ("name", "mode", "part", "tool", "per_tick"),
    [
        ("cartesian-delta", ControlMode.CARTESIAN_DELTA, "right_arm", "right_tcp", 1.0),
        ("cartesian-twist", ControlMode.CARTESIAN_TWIST, "left_arm", "left_tcp", 0.05),
    ],
)
def test_cartesian_delta_and_twist_move_the_tool_along_base_links_axes(
    robot: ModeRobot, name: str, mode: ControlMode, part: str, tool: str, per_tick: float
) -> None:
    story = robot.run(name)
    scale = DELTA_SCALE if mode is ControlMode.CARTESIAN_DELTA else TWIST_SCALE
    wire = np.array(HALVES) * scale
    assert story.row(PARTS[part])[:2] == (mode, "base_link")
    np.testing.assert_array_equal(story.row(PARTS[part])[2], wire)
    ticks = len(story.acted(PARTS[part]))
    assert ticks >= 6
    shift, turn = GEOMETRY.moved(story, tool)
    np.testing.assert_allclose(shift, ticks * per_tick * wire[:3], rtol=0, atol=ARRIVED)
    np.testing.assert_allclose(turn, ticks * per_tick * wire[3:], rtol=0, atol=ARRIVED)
    others_are_still(story, part)


@pytest.mark.parametrize(
    ("name", "mode", "value", "opening"),
    [
        ("gripper-closed", ControlMode.GRIPPER_BINARY, 1.0, 0.0),
        ("gripper-open", ControlMode.GRIPPER_BINARY, 0.0, 0.08),
        ("gripper-position", ControlMode.GRIPPER_POSITION, 0.03, 0.03),
    ],
)
def test_a_gripper_closes_opens_or_goes_to_its_opening_with_both_fingers(
    robot: ModeRobot, name: str, mode: ControlMode, value: float, opening: float
) -> None:
    story = robot.run(name)
    found, frame, row, active = story.row(PARTS["left_gripper"])
    assert (found, frame, active) == (mode, "", ())
    np.testing.assert_array_equal(row, [value])
    total, left, right = story.end[[ROBOT.joint_names.index("left_gripper"), N, N + 1]]
    np.testing.assert_allclose(
        [total, left, right], [opening, opening / 2, -opening / 2], rtol=0, atol=2e-4
    )
    others_are_still(story, "left_gripper")


def test_dex_hand_joint_bends_each_finger_joint(robot: ModeRobot) -> None:
    story = robot.run("dex-hand")
    mode, frame, row, active = story.row(PARTS["right_hand"])
    assert (mode, frame, active) == (ControlMode.DEX_HAND_JOINT, "", mask(HAND))
    np.testing.assert_array_equal(row, joints_row(dict(zip(HAND, exact(BENT), strict=True))))
    np.testing.assert_allclose(moved(story, HAND), SEVEN[:6], rtol=0, atol=ARRIVED)
    others_are_still(story, "right_hand")


def test_one_chunk_moves_both_arms_the_gripper_and_the_hand(robot: ModeRobot) -> None:
    story = robot.run("both-arms")
    assert all(len(chunk.parts) == 4 for chunk in story.released)
    ticks = len(story.acted(0))
    assert ticks >= 6 and all(len(story.acted(part)) == ticks for part in range(4))
    for tool, scale, share in (("right_tcp", TWIST_SCALE, 0.05), ("left_tcp", DELTA_SCALE, 1.0)):
        wanted = ticks * share * np.array(HALVES) * scale
        np.testing.assert_allclose(
            np.concatenate(GEOMETRY.moved(story, tool)), wanted, rtol=0, atol=ARRIVED
        )
    np.testing.assert_allclose(moved(story, HAND), SEVEN[:6], rtol=0, atol=ARRIVED)
    assert story.end[ROBOT.joint_names.index("left_gripper")] < ARRIVED


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_a_chunk_just_above_a_limit_is_refused_with_its_evidence_and_nothing_moves(
    robot: ModeRobot, name: str
) -> None:
    _, code, part, axis, value, limit = REFUSED[name]
    story = robot.run(name)
    assert story.refusals and not story.released, story.verdicts
    for verdict in story.refusals:
        assert (verdict.code, verdict.row, verdict.part, verdict.axis) == (code, 0, part, axis)
        np.testing.assert_allclose([verdict.value, verdict.limit], [value, limit], rtol=1e-4)
    assert not any(story.acted(index) for index in PARTS.values())
    assert np.abs(story.end - story.start).max() < STILL
