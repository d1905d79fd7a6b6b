"""The same skills move the simulated arm and the emulated one: one line differs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from bench.equipment.emulated_arm import emulated_arm
from bench.equipment.live_robot import LiveRobot
from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, GoalResult, floats
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead.skill.manifest import load_skill
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.so101.arm import as_delivered

SOURCE = repo_root() / "compose" / "so101_mujoco.yaml"
SKILL, TOOL_SKILL = "so101-reach", "so101-tool-motion"
BOTH = {"runner": {"skills": [SKILL, TOOL_SKILL]}}
TICKS, ROW_M = 100, 0.001 * np.array([0.4, 0.4, 0.5])
TARGET = np.array(load_skill(SKILL).policy.options["target_rad"], dtype=float)

pytestmark = [pytest.mark.processes]


def reach(robot: ScratchRobot) -> tuple[GoalResult, FloatArray]:
    """One goal: its result, and where the joints are after it."""
    robot.client.arm()
    wish = GoalOptions(SKILL, deadline_ticks=1500, stall_timeout_s=15.0)
    result = run_goal(robot.client, wish).result
    assert result is not None
    return result, measured(robot)


def measured(robot: ScratchRobot) -> FloatArray:
    """Where the joints are [rad]."""
    with robot.client.joint_states(queue=1) as states:
        state = states.next(5.0)
    assert state is not None
    return floats(state.positions)


def tool(robot: ScratchRobot) -> FloatArray:
    """Where the tool is in base_link [m]."""
    for batch in robot.client.transforms():
        for one in batch.transforms:
            if one.child == "tool":
                return floats(one.translation)
    raise AssertionError


LATE = {"G006", "G011", "G012"}
"""Codes of chunks and states that a busy machine brought too late."""


def tool_goes_as_told(robot: ScratchRobot) -> None:
    """A goal of deltas; the way is that of its rows, less what the servos lag behind."""
    start = tool(robot)
    robot.client.arm()
    rows = 0  # a busy machine holds some ticks
    with robot.client.joint_states(queue=5000) as states:
        result = run_goal(robot.client, GoalOptions(TOOL_SKILL, deadline_ticks=TICKS)).result
        assert result is not None and result.outcome == "deadline", result
        for state in states:
            rows += state.acted[0].hold == 0
            if state.tick > result.last_tick + 20:
                break
    assert TICKS / 2 < rows <= TICKS
    np.testing.assert_allclose(tool(robot) - start, rows * ROW_M, rtol=0, atol=0.008)
    counters = dict(robot.client.gate_status().counters)
    refused = {name for name in counters if name.startswith("G") and counters[name]}
    assert refused <= LATE
    robot.client.disarm()


def swapped(folder: Path, port: Path) -> Path:
    """The shipped file with another line for the HAL."""
    options = f"{{port: {port}, calibration: {as_delivered(folder)}, answer_timeout_s: 0.2}}"
    before = SOURCE.read_text(encoding="utf-8").splitlines()
    [line] = [number for number, text in enumerate(before) if text.startswith("  hal: {")]
    after = list(before)
    after[line] = before[line].replace("run: hal_mujoco", f"run: hal_so101, options: {options}")
    file = folder / "swapped.yaml"
    file.write_text("\n".join(after), encoding="utf-8")
    assert sum(one != other for one, other in zip(before, after, strict=True)) == 1
    assert yaml.safe_load(file.read_text())["services"]["hal"]["run"] == "hal_so101"
    return file


def test_the_skills_move_tool_and_joints_on_the_simulator(tmp_path: Path) -> None:
    options = ScratchOptions(options=BOTH)
    scratch = make_scratch(SOURCE, tmp_path / "state", options)
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        tool_goes_as_told(robot)
        result, joints = reach(robot)
    assert (result.outcome, result.decided_by) == ("succeeded", "policy"), result
    np.testing.assert_allclose(joints, TARGET, rtol=0, atol=0.04)


def test_the_skills_move_tool_and_joints_on_servos_and_a_hot_one_stops_them(tmp_path: Path) -> None:
    with emulated_arm(tmp_path / "arm") as arm:
        options = ScratchOptions(options=BOTH)
        scratch = make_scratch(swapped(tmp_path, arm.port), tmp_path / "state", options)
        with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
            tool_goes_as_told(robot)
            arm.order("temperature 3 66")
            still = measured(robot)
            result, joints = reach(robot)
            assert result.outcome == "failed", result
            assert "servo 3 (elbow_flex): 66 C, limit 60 C" in result.detail
            np.testing.assert_allclose(joints, still, rtol=0, atol=0.05)
            arm.order("temperature 3 30")
            LiveRobot(robot, SKILL).recover()
            result, joints = reach(robot)
    assert (result.outcome, result.decided_by) == ("succeeded", "policy"), result
    np.testing.assert_allclose(joints, TARGET, rtol=0, atol=0.04)
