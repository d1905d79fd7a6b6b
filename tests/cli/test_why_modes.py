"""``fairlead why`` for a refusal in each control mode: its numbers with their unit, what passes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from bench.equipment.running_gate import ROBOT as MOBILE
from fairlead.messages import ActionPart, Outcome, Verdict, pack_floats
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.cli.command import fairlead_here as fairlead
from tests.gate.two_armed_scene import action, per_joint, tool_pose, two_armed_scene

pytestmark = pytest.mark.processes

Rows = Callable[[Scene, float], ActionPart]
"""What is asked for, or a share of it, as counted from what is measured."""
PASSES = "passes  the whole chunk, asked of this gate with "
FOUND_WITHIN, ROUNDED = 1.002, 1 - 1e-6
"""A share is told with four digits, rounded down: times the first it does not pass any more."""

A_BIT_MORE = float(np.nextafter(0.08, 1.0))
"""Than the limit of an opening: six digits of both are the same."""


def joints(mode: ControlMode, part: str, first: float) -> Rows:
    return lambda scene, share: per_joint(scene, part, mode, first * share)


def same_rows(part: str, mode: ControlMode, row: list[float], frame: str = "") -> Rows:
    return lambda _, share: action(part, mode, [np.array(row) * share] * 2, frame)


def pose_beside(scene: Scene, share: float) -> ActionPart:
    pose = tool_pose(scene, "left_arm")
    pose[0] += 0.06 * share
    return action("left_arm", ControlMode.CARTESIAN_POSE, [pose, pose], "base_link")


def pose_turned(scene: Scene, share: float) -> ActionPart:
    """By 0.2 rad about base_link's z."""
    pose = tool_pose(scene, "left_arm")
    x, y, z, w = pose[3:]
    s, c = np.sin(0.1 * share), np.cos(0.1 * share)
    pose[3:] = [c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z]
    return action("left_arm", ControlMode.CARTESIAN_POSE, [pose, pose], "base_link")


def part_of(
    part: int,
    mode: ControlMode,
    row: list[float],
    frame: str = "",
    active: tuple[int, ...] = (),
) -> ActionPart:
    values = pack_floats(np.array([row, row]))
    return ActionPart(part=part, mode=mode, frame_id=frame, values=values, active=active)


def first_opening(_: Scene, opening_m: float) -> ActionPart:
    rows = [np.array([opening_m]), np.array([0.04])]
    return action("left_gripper", ControlMode.GRIPPER_POSITION, rows)


TWO_ARMED: dict[str, tuple[Rows, str, str]] = {
    "joint_position": (
        joints(ControlMode.JOINT_POSITION, "left_arm", 60.0),
        "G020 limit: row 0, left_arm left_joint1 is 60 rad, limit 2.8973 rad, 57.1027 rad beyond",
        "every number of left_arm times {share} about the measured position",
    ),
    "joint_velocity": (
        joints(ControlMode.JOINT_VELOCITY, "left_arm", 60.0),
        "left_joint1 is 60 rad/s, limit 2.175 rad/s, 57.825 rad/s beyond it",
        "every number of left_arm times {share}",
    ),
    "dex_hand_joint": (
        joints(ControlMode.DEX_HAND_JOINT, "right_hand", 60.0),
        "right_thumb_joint1 is 60 rad, limit",
        "every number of right_hand times {share} about the measured position",
    ),
    "cartesian_pose, place": (
        pose_beside,
        "left_arm linear is 0.06 m, limit 0.05 m, 0.01 m beyond it",
        "every number of left_arm times {share} about the measured pose",
    ),
    "cartesian_pose, angle": (
        pose_turned,
        "left_arm angular is 0.2 rad, limit 0.125 rad, 0.075 rad beyond it",
        "every number of left_arm times {share} about the measured pose",
    ),
    "cartesian_delta": (
        same_rows("left_arm", ControlMode.CARTESIAN_DELTA, [0, 1.1, 0, 0, 0, 0], "base_link"),
        "left_arm linear is 1.1 m, limit 0.05 m, 1.05 m beyond it",
        "every number of left_arm times {share}",
    ),
    "cartesian_twist": (
        same_rows("left_arm", ControlMode.CARTESIAN_TWIST, [0, 0, 0, 0, 2.6, 0], "base_link"),
        "left_arm angular is 2.6 rad/s, limit 2.5 rad/s, 0.1 rad/s beyond it",
        "every number of left_arm times {share}",
    ),
    "gripper_binary": (
        same_rows("left_gripper", ControlMode.GRIPPER_BINARY, [0.75]),
        "left_gripper closed is 0.75, limit 1, 0.25 beyond it",
        "every number of left_gripper 0 or 1, whichever is nearer",
    ),
    "gripper_position": (
        same_rows("left_gripper", ControlMode.GRIPPER_POSITION, [0.2]),
        "left_gripper opening is 0.2 m, limit 0.08 m, 0.12 m beyond it",
        "every number of left_gripper times {share} about the measured position",
    ),
    "a rounding fault in every row": (
        same_rows("left_gripper", ControlMode.GRIPPER_POSITION, [A_BIT_MORE]),
        f"left_gripper opening is {A_BIT_MORE!r} m, limit 0.08 m",
        "every number of left_gripper times {share} about the measured position",
    ),
}


def judged(scene: Scene, part: ActionPart) -> Verdict:
    """The gate's verdict on two rows; the robot stands, before and after."""
    verdict = scene.send(scene.chunk(rows=2, parts=(part,)))
    scene.next_tick()
    scene.next_tick()
    return verdict


def told_share(said: str, passes: str) -> float | None:
    """The number in place of ``{share}``; None for words that have none."""
    pattern = re.escape(f"{PASSES}{passes}\n").replace(r"\{share\}", r"(0\.\d+)")
    found = re.search(pattern, said)
    assert found, said
    return float(found[1]) if found.groups() else None


def assert_the_most_that_passes(
    fresh: Callable[[Path], Scene], rows: Rows, share: float, folder: Path
) -> None:
    """Each is asked of a gate and a robot that have done nothing yet."""
    for name, asked, passes in (
        ("beyond", share * FOUND_WITHIN, False),
        ("passing", share * ROUNDED, True),
    ):
        with closing(fresh(folder / name)) as scene:
            verdict = judged(scene, rows(scene, asked))
            assert (verdict.outcome == Outcome.RELEASED) == passes, verdict


class Refusals:
    """One refused chunk after the other, each at a tick of its own, and what ``why`` says."""

    def __init__(self, scene: Scene, folder: Path) -> None:
        self.scene, self.folder = scene, folder
        self.ticks: dict[str, int] = {}

    def ask(self, name: str, part: ActionPart) -> None:
        self.ticks[name] = self.scene.hal.tick
        verdict = judged(self.scene, part)
        assert verdict.outcome == Outcome.REFUSED, verdict

    def why(self, name: str) -> str:
        words = ("why", str(self.ticks[name]), "--log", str(self.folder / "decisions"))
        done = fairlead(*words, state=self.folder / "registry")
        assert done.returncode == 0, done.stderr
        return str(done.stdout)


@pytest.fixture(scope="module")
def two_armed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Refusals]:
    folder = tmp_path_factory.mktemp("two_armed")
    scene = two_armed_scene(folder)
    refusals = Refusals(scene, folder)
    for name, (rows, _, _) in TWO_ARMED.items():
        refusals.ask(name, rows(scene, 1.0))
    refusals.ask("one row", first_opening(scene, A_BIT_MORE))
    scene.silence()
    assert scene.gate.stop() == 0
    yield refusals
    scene.close()


@pytest.mark.parametrize("name", TWO_ARMED)
def test_a_refusal_says_its_numbers_with_their_unit_and_the_most_that_would_have_passed(
    two_armed: Refusals, tmp_path: Path, name: str
) -> None:
    _, numbers, passes = TWO_ARMED[name]
    said = two_armed.why(name)
    assert numbers in said
    share = told_share(said, passes)
    if share is not None:
        assert_the_most_that_passes(two_armed_scene, TWO_ARMED[name][0], share, tmp_path)


def test_of_a_rounding_fault_in_one_row_the_number_is_told_that_passes(
    two_armed: Refusals, tmp_path: Path
) -> None:
    where = "left_gripper opening in row 0"
    told = f"{PASSES}{where} at (.*) m instead of {A_BIT_MORE!r} m\n"
    found = re.search(told, two_armed.why("one row"))
    assert found, two_armed.why("one row")
    with closing(two_armed_scene(tmp_path)) as scene:
        passing = judged(scene, first_opening(scene, float(found[1])))
    assert passing.outcome == Outcome.RELEASED


def mobile_scene(folder: Path) -> Scene:
    scene = Scene(gate_config(MOBILE, "sim"), folder)
    scene.meet_hal()
    scene.arm()
    scene.take_claim("arm", "gripper", "base", "composite")
    return scene


def slide(_: Scene, share: float) -> ActionPart:
    """The base sideways, at 1.5 m/s."""
    row = [0.0, 1.5 * share] + [0.0] * 9
    return part_of(2, ControlMode.JOINT_VELOCITY, row, active=(0, 1, 2))


def switch(_: Scene, share: float) -> ActionPart:
    return part_of(3, ControlMode.COMPOSITE_MODE, [1.5 * share])


@pytest.fixture(scope="module")
def mobile(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Refusals]:
    folder = tmp_path_factory.mktemp("mobile")
    scene = mobile_scene(folder)
    refusals = Refusals(scene, folder)
    refusals.ask("joint_velocity", slide(scene, 1.0))
    twist = [0.0, 3.0, 0.0, 0.0, 0.0, 0.0]
    refusals.ask("body_twist", part_of(2, ControlMode.BODY_TWIST, twist, "base_link"))
    refusals.ask("composite", switch(scene, 1.0))
    scene.silence()
    assert scene.gate.stop() == 0
    yield refusals
    scene.close()


def test_a_slide_of_the_base_is_told_in_metres_per_second(mobile: Refusals, tmp_path: Path) -> None:
    said = mobile.why("joint_velocity")
    assert "base base_y is 1.5 m/s, limit 1 m/s, 0.5 m/s beyond it" in said
    share = told_share(said, "every number of base times {share}")
    assert share is not None
    assert_the_most_that_passes(mobile_scene, slide, share, tmp_path)


def test_a_twist_of_the_base_is_told_in_metres_per_second(mobile: Refusals) -> None:
    assert "base linear is 3 m/s, limit " in mobile.why("body_twist")


def test_a_composite_switch_has_no_unit(mobile: Refusals, tmp_path: Path) -> None:
    said = mobile.why("composite")
    assert "composite composite is 1.5, limit 1, 0.5 beyond it" in said
    share = told_share(said, "every number of composite times {share}")
    assert share is not None
    assert_the_most_that_passes(mobile_scene, switch, share, tmp_path)


def test_a_hand_that_turns_is_told_in_radians(tmp_path: Path) -> None:
    robot = load_robot("ur5e")
    home = [-0.47, -1.735, 2.48, -2.275, -1.59, -1.991, 0.1]
    with closing(Scene(gate_config(robot.id, "sim"), tmp_path, robot=robot.id)) as scene:
        scene.hal.positions = np.array(home)
        scene.meet_hal()
        scene.arm()
        scene.take_claim(*robot.part_names)
        refusals = Refusals(scene, tmp_path)
        refusals.ask("jaw", part_of(1, ControlMode.GRIPPER_POSITION, [2.2]))
        scene.silence()
        assert scene.gate.stop() == 0
        said = refusals.why("jaw")
    assert "gripper opening is 2.2 rad, limit 0.8 rad, 1.4 rad beyond it" in said
    assert "safety.sim.parts.gripper.gripper_position.upper_rad" in said
