"""The arms that ship as data: a reach and a tool's motion of each, through the gate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.equipment.kinematics import Kinematics
from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, GoalResult, JointState, TransformBatch, decode, floats
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

pytestmark = pytest.mark.processes
MOST_TICKS = 80


class Seen:
    """The newest joints, and every frame that the HAL publishes."""

    def __init__(self, robot: ScratchRobot) -> None:
        self.positions: FloatArray = np.zeros(0)
        self.frames: set[str] = set()
        bus, keys = robot.client.bus, robot.client.keys
        self._subscriptions = [
            bus.subscribe(keys.joints, self._on_joints),
            bus.subscribe(keys.tf("hal"), self._on_transforms),
        ]

    def _on_joints(self, sample: Sample) -> None:
        self.positions = floats(decode(JointState, sample.payload).positions)

    def _on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        self.frames |= {one.child for one in batch.transforms}


def goal(robot: ScratchRobot, skill: str, ticks: int) -> GoalResult:
    robot.client.disarm()
    robot.client.reset_episode(1)
    robot.client.arm()
    wish = GoalOptions(skill, deadline_ticks=ticks, stall_timeout_s=10.0)
    ended = run_goal(robot.client, wish)
    robot.client.disarm()
    assert ended.result is not None and not ended.last_refusal, ended
    return ended.result


@pytest.mark.parametrize(
    ("arm", "simulator"),
    [
        ("kinova3", "mujoco"),
        pytest.param("ur5e", "mujoco", marks=pytest.mark.thorough),
        pytest.param("ur5e", "robosuite", marks=pytest.mark.thorough),
    ],
)
def test_an_arm_reaches_a_pose_and_moves_its_tool(arm: str, simulator: str, tmp_path: Path) -> None:
    manifest = load_robot(arm)
    source = repo_root() / "compose" / f"{arm}_{simulator}.yaml"
    skills = [f"{arm}-reach", f"{arm}-tool-motion"]
    options = ScratchOptions(options={"runner": {"skills": skills}})
    scratch = make_scratch(source, tmp_path / "state", options)
    kinematics = Kinematics(manifest.description_path(), manifest.measured_joint_names)

    def tool(seen: Seen) -> FloatArray:
        return kinematics.pose(seen.positions, "grip_site", "base_link")[0]

    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        seen = Seen(robot)
        if simulator == "mujoco":  # robosuite's controller takes deltas only
            result = goal(robot, skills[0], MOST_TICKS)
            assert (result.outcome, result.decided_by) == ("succeeded", "policy"), result
            target = load_skill(skills[0]).policy.options["target_rad"]
            joints = seen.positions[: manifest.n_dof - 1]
            np.testing.assert_allclose(joints, np.array(target), atol=0.06)
        result = goal(robot, skills[1], 1)
        start = tool(seen)
        result = goal(robot, skills[1], 24)
        assert result.outcome == "deadline", result
        way = tool(seen) - start
        assert way[2] > 0.01 and np.linalg.norm(way) > 0.02, way
        turned = 0.3 if simulator == "mujoco" else 0.1  # robosuite's hand gets there slowly
        assert seen.positions[manifest.n_dof - 1] > turned, "the hand turns, in radians"
        result = goal(robot, skills[1], 100)
        assert (result.outcome, result.decided_by) == ("succeeded", "policy"), result
        assert ("cube" in seen.frames) == (simulator == "robosuite")
