"""A ROS 2 robot behind the real gate: it does a skill, and stops when it falls silent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.messages import JointState, StopLevel, decode, floats
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.hal_mujoco.joint_reach import RUNNER, SKILL, SOURCE, goal_position
from tests.ros2.ros_process import FINGERS, JOINTS, StartRos, panda_options

pytestmark = pytest.mark.processes


def test_a_ros_2_robot_does_a_skill_through_the_gate_and_stops_when_it_falls_silent(
    router: str, start_ros: StartRos, tmp_path: Path
) -> None:
    ros = start_ros(joints=JOINTS | FINGERS, positions=list(FINGERS))
    hal = {"run": "hal_ros2", "options": panda_options(router)}
    wanted = ScratchOptions(pacing="realtime", hal=hal, options={"runner": RUNNER})
    with scratch_robot(make_scratch(SOURCE, tmp_path / "state", wanted)) as robot:
        client = robot.client
        states: list[JointState] = []
        stops: list[StopLevel] = []
        client.bus.subscribe(
            client.keys.joints, lambda sample: states.append(decode(JointState, sample.payload))
        )
        client.bus.subscribe(
            client.keys.stop, lambda sample: stops.append(decode(StopLevel, sample.payload))
        )
        client.arm()
        result = run_goal(client, GoalOptions(SKILL, deadline_ticks=80)).result
        assert result is not None
        assert result.outcome == "deadline", "it has no task that could succeed"
        np.testing.assert_allclose(floats(states[-1].positions)[:8], goal_position(), atol=0.02)
        told = [one for one in ros.got if one["got"] == "trajectory"]
        assert told[-1]["names"] == list(JOINTS)
        assert {one["takes_s"] for one in told} == {0.05}
        assert ros.values("positions")[-1] == pytest.approx([goal_position()[7] / 2] * 2)

        ros.tell("mute")
        ros.wait(lambda: bool(stops), "the stop")
        assert "topic /joint_states: the newest state is 0.2" in stops[0].reason
        ros.wait(lambda: client.hal_status().state == "fault", "the HAL to say so")
        assert "hal_ros2: topic /joint_states: the newest state" in client.hal_status().detail
        ticks = states[-1].tick
        ros.tell("speak")
        assert client.hal_status().state == "fault", "until it is started again"
        assert states[-1].tick == ticks
