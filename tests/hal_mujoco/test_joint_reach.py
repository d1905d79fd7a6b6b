"""A fixed arm in plain MuJoCo: the same gate, runner and assembler, another HAL."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import yaml

from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import MotionLog
from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, GoalResult, JointState, decode, floats
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.hal_mujoco.joint_reach import RUNNER, SKILL, SOURCE, goal_position

DEADLINE_TICKS = 120
Pacing = Literal["realtime", "lockstep"]

pytestmark = pytest.mark.processes


def reach(robot: ScratchRobot, seed: int) -> tuple[GoalResult, FloatArray]:
    """One goal in a new episode: its result, and the commanded joints at its end."""
    client, n_dof = robot.client, load_robot("panda").n_dof
    states: list[JointState] = []

    def on_joints(sample: Sample) -> None:
        states.append(decode(JointState, sample.payload))

    subscription = client.bus.subscribe(client.keys.joints, on_joints)
    client.disarm()
    client.reset_episode(seed)
    client.arm()
    wish = GoalOptions(SKILL, deadline_ticks=DEADLINE_TICKS, stall_timeout_s=10.0)
    result = run_goal(client, wish).result
    client.disarm()
    assert result is not None
    wait_for(lambda: any(s.tick == result.last_tick for s in states), "the state of the last tick")
    subscription.undeclare()
    last = next(s for s in states if s.tick == result.last_tick)
    return result, floats(last.positions)[:n_dof]


@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_joint_reach_is_a_success_of_the_simulators_own_task(
    pacing: Pacing, tmp_path: Path
) -> None:
    scratch = make_scratch(
        SOURCE, tmp_path / "state", ScratchOptions(pacing=pacing, options={"runner": RUNNER})
    )
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        result, joints = reach(robot, seed=3)
        assert (result.outcome, result.decided_by) == ("succeeded", "task"), result
        assert result.last_tick - result.first_tick > 10, "it was there from the start"
        np.testing.assert_allclose(joints[:7], goal_position()[:7], rtol=0, atol=0.02)
        np.testing.assert_allclose(joints[7], goal_position()[7], rtol=0, atol=0.002)
        assert any(line.moves for line in MotionLog(scratch.state_dir / "hal").read())


def test_a_lockstep_run_repeats_bit_for_bit(tmp_path: Path) -> None:
    options = ScratchOptions(options={"runner": RUNNER})
    scratch = make_scratch(SOURCE, tmp_path / "state", options)
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        first, second = (reach(robot, seed=5)[1] for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_another_hal_is_one_line_of_the_deployment_file(tmp_path: Path) -> None:
    text = SOURCE.read_text(encoding="utf-8")
    lines = text.splitlines()
    [offered] = [line.lstrip("# ") for line in lines if line.startswith("#   hal: {")]
    [used] = [number for number, line in enumerate(lines) if line.startswith("  hal: {")]
    lines[used] = f"  {offered}"
    swapped = tmp_path / "swapped.yaml"
    swapped.write_text("\n".join(lines), encoding="utf-8")
    before, after = yaml.safe_load(text), yaml.safe_load(swapped.read_text(encoding="utf-8"))
    assert before["services"].pop("hal") != after["services"].pop("hal")
    assert before == after
    assert load_deployment(swapped).services["hal"].run == "hal_kinematic"

    scratch = make_scratch(swapped, tmp_path / "state", ScratchOptions(options={"runner": RUNNER}))
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        result, joints = reach(robot, seed=3)
    assert result.outcome == "deadline", "the kinematic robot has no task that could succeed"
    np.testing.assert_allclose(joints, goal_position(), rtol=0, atol=1e-6)
