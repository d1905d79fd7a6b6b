"""The modes only a mobile base in robosuite has: body twists, and its controller's switch."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, TransformBatch, decode, floats
from fairlead.modes import ControlMode
from fairlead.paths import SKILLS_VARIABLE, repo_root
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.system.mode_robot import ModeRobot, ModeSkill, write_skills
from tests.system.tool_geometry import ToolGeometry

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
ROBOT = load_robot("panda_mobile")
ARM, GRIPPER, BASE, SWITCH = range(4)
GEOMETRY = ToolGeometry(ROBOT)
STATE = {"layout": "libero", "dim": 9}
PERIOD_S = ROBOT.tick_period_ns * 1e-9
LINEAR, YAW = 0.4, 1.17
"""Limits of robot.yaml [m/s, rad/s]; the skill's scales."""

TWIST = {"control_mode": "body_twist", "axes": [0, 1, 5], "scale": [LINEAR, LINEAR, YAW]}
MODE = {"control_mode": "composite_mode"}
NUMBERS = (0.5, -0.25, 0.125)
GATHERING = 5
"""Ticks in which the base gathers speed."""

DELTA = {
    "control_mode": "cartesian_delta", "ee": "gripper", "frame": "base_link",
    "scale": [0.05, 0.05, 0.05, 0.5, 0.5, 0.5],
}  # fmt: skip
OPENING = {"control_mode": "gripper_position", "ee": "gripper", "scale": -0.04, "offset": 0.04}
STILL = (0.0,) * 6
SHIFT, TURN = (0.5, -0.25, 0.125, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0625, -0.125, 0.25)
STILL_M, STILL_RAD = 0.08, 0.05
"""What the simulator's controller moves an arm by on axes that it is told nothing of: one that
only turns it also shifts it, by 5 cm here."""

SKILLS = {
    "shift": ModeSkill((OPENING, DELTA), ((-1.0,), SHIFT), ticks=16),
    "turn": ModeSkill((DELTA, OPENING), (TURN, (1.0,)), ticks=16),
    "drive": ModeSkill((MODE, TWIST, DELTA), ((-0.75,), NUMBERS, STILL), ticks=24),
    "twist-limit": ModeSkill((TWIST,), ((0.0, -1.001, 0.0),), ticks=3),
    "switch-limit": ModeSkill((MODE, DELTA), ((1.001,), STILL), ticks=3),
}


class Base:
    """Where ``base_link`` was at each tick: x, y [m] and yaw [rad] in odom."""

    def __init__(self) -> None:
        self.poses: dict[int, FloatArray] = {}

    def on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        for one in batch.transforms:
            if (one.parent, one.child) == ("odom", "base_link"):
                x, y, _ = floats(one.translation)
                _, _, z, w = floats(one.rotation_xyzw)
                self.poses[batch.tick] = np.array([x, y, 2 * np.arctan2(z, w)])

    def twist(self, first: int, last: int) -> FloatArray:
        """Mean vx, vy [m/s], turn rate [rad/s] between ticks, along the base's own axes."""
        found = []
        for tick in range(first, last):
            before, after = self.poses[tick], self.poses[tick + 1]
            middle = (before[2] + after[2]) / 2
            c, s = np.cos(middle), np.sin(middle)
            dx, dy, turn = after - before
            found.append([c * dx + s * dy, c * dy - s * dx, turn])
        return np.asarray(np.mean(found, axis=0) / PERIOD_S)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("modes")


@pytest.fixture(scope="module")
def base() -> Base:
    return Base()


@pytest.fixture(scope="module")
def robot(folder: Path, base: Base) -> Iterator[ModeRobot]:
    write_skills(folder / "rskills", SKILLS, ROBOT, STATE)
    options: dict[str, dict[str, Any]] = {
        "hal": {"trace": True},
        "runner": {"skills": list(SKILLS)},
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SKILLS_VARIABLE, str(folder / "rskills"))
        scratch = make_scratch(SOURCE, folder / "state", ScratchOptions(options=options))
        with scratch_robot(scratch, Registry(folder / "registry")) as running:
            running.client.bus.subscribe(running.client.keys.every_tf, base.on_transforms)
            yield ModeRobot(running, SKILLS)


def packed(folder: Path) -> dict[int, FloatArray]:
    """What the simulator was given, by tick."""
    text = (folder / "state" / "hal" / "trace.jsonl").read_text(encoding="utf-8")
    entries = [json.loads(line) for line in text.splitlines()]
    return {e["tick"]: np.frombuffer(bytes.fromhex(e["packed"]), "<f4") for e in entries}


def test_a_body_twist_drives_as_it_says_while_the_switch_reaches_the_controller(
    robot: ModeRobot, base: Base, folder: Path
) -> None:
    story = robot.run("drive")
    vx, vy, turn = np.array(NUMBERS) * [LINEAR, LINEAR, YAW]
    mode, frame, row, active = story.row(BASE)
    assert (mode, frame, active) == (ControlMode.BODY_TWIST, "base_link", ())
    np.testing.assert_array_equal(row, [vx, vy, 0, 0, 0, turn])
    mode, frame, row, active = story.row(SWITCH)
    assert (mode, frame, active) == (ControlMode.COMPOSITE_MODE, "", ())
    np.testing.assert_array_equal(row, [-0.75])

    ticks = [state.tick - 1 for state in story.acted(BASE)]
    assert len(ticks) >= 20
    found = base.twist(ticks[GATHERING], ticks[-1])
    np.testing.assert_allclose(found[:2], [vx, vy], rtol=0, atol=0.03)
    np.testing.assert_allclose(found[2], turn, rtol=0.15)
    given = packed(folder)
    assert {float(given[tick][11]) for tick in ticks} == {-0.75}
    assert not any(given[tick][:6].any() for tick in ticks), "the arm was told nothing"


def along(found: FloatArray, told: FloatArray) -> float:
    """Cosine of the angle between a motion and what was told."""
    return float(found @ told / np.linalg.norm(found) / np.linalg.norm(told))


def test_the_arm_moves_along_its_delta_and_the_gripper_opens(robot: ModeRobot) -> None:
    story = robot.run("shift")
    told = np.array(SHIFT) * DELTA["scale"]
    mode, frame, row, active = story.row(ARM)
    assert (mode, frame, active) == (ControlMode.CARTESIAN_DELTA, "base_link", ())
    np.testing.assert_array_equal(row, told)
    assert story.row(GRIPPER)[0] == ControlMode.GRIPPER_POSITION
    np.testing.assert_array_equal(story.row(GRIPPER)[2], [0.08])
    shift, turn = GEOMETRY.moved(story, "grip_site")
    assert along(shift, told[:3]) > 0.98 and np.linalg.norm(shift) > 0.05, shift
    assert np.linalg.norm(turn) < STILL_RAD, turn
    assert story.end[ROBOT.joint_names.index("panda_gripper")] > 0.07


def test_the_arm_turns_about_its_delta_and_the_gripper_closes(robot: ModeRobot) -> None:
    story = robot.run("turn")
    told = np.array(TURN) * DELTA["scale"]
    np.testing.assert_array_equal(story.row(ARM)[2], told)
    np.testing.assert_array_equal(story.row(GRIPPER)[2], [0.0])
    shift, turn = GEOMETRY.moved(story, "grip_site")
    assert along(turn, told[3:]) > 0.98 and np.linalg.norm(turn) > 0.3, turn
    assert np.linalg.norm(shift) < STILL_M, shift
    assert story.end[ROBOT.joint_names.index("panda_gripper")] < 0.01


@pytest.mark.parametrize(
    ("name", "part", "axis", "value", "limit"),
    [
        ("twist-limit", "base", "linear", LINEAR * 1.001, LINEAR),
        ("switch-limit", "composite", "composite", 1.001, 1.0),
    ],
)
def test_just_above_a_limit_is_refused_with_its_evidence_and_the_base_stands(
    robot: ModeRobot, base: Base, name: str, part: str, axis: str, value: float, limit: float
) -> None:
    story = robot.run(name)
    assert story.refusals and not story.released, story.verdicts
    for verdict in story.refusals:
        assert (verdict.code, verdict.row, verdict.part, verdict.axis) == (20, 0, part, axis)
        np.testing.assert_allclose([verdict.value, verdict.limit], [value, limit], rtol=1e-4)
    first, last = story.states[0].tick, story.states[-1].tick
    assert np.abs(base.poses[last] - base.poses[first]).max() < 1e-3
