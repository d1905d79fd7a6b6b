"""A ROS 2 robot behind the real gate: it does a skill, and stops when it falls silent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.checked_model import checked_model
from fairlead.messages import JointState, StopLevel, decode, floats
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.ros2.node import RosNode
from fairlead.wire.bus import Sample
from fairlead_hal_ros2.joint_states import JointSource
from fairlead_hal_ros2.options import PartTopic, Ros2Options
from fairlead_hal_ros2.part_drive import PartDrive
from fairlead_hal_ros2.ros2_backend import REST_PERIODS
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


class Watched:
    """What was measured of a robot's first joint, from the newest tick on."""

    def __init__(self, client: RobotClient) -> None:
        self.first: list[float] = []
        self.ticks, self._still = [0], list[bool]()
        client.bus.subscribe(client.keys.joints, self._keep)

    def _keep(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        self._still.append(not floats(state.velocities).any())
        self.first.append(floats(state.positions)[0])
        self.ticks.append(state.tick)

    def rests_at(self, place: float) -> bool:
        return abs(self.first[-1] - place) < 0.01 and all(self._still[-5:])


@pytest.mark.parametrize("leaves_out", [False, True])
def test_a_row_goes_on_from_where_somebody_else_has_moved_the_arm_meanwhile(
    leaves_out: bool, router: str, start_ros: StartRos, tmp_path: Path
) -> None:
    ros = start_ros(joints=JOINTS | FINGERS, positions=list(FINGERS))
    options, moved = panda_options(router), 0.8
    hal = {"run": "hal_ros2", "options": options}
    wanted = ScratchOptions(pacing="realtime", hal=hal, options={"runner": RUNNER})
    with scratch_robot(make_scratch(SOURCE, tmp_path / "state", wanted)) as robot:
        client, seen = robot.client, Watched(robot.client)
        ros.wait(lambda: seen.ticks[-1] > REST_PERIODS + 5, "the HAL to fall silent")
        with another_commander(options) as send:
            send([moved, *list(JOINTS.values())[1:]])
            ros.wait(lambda: seen.rests_at(moved), "the other one to move the arm")
        client.arm()
        told = len(ros.values("trajectory"))
        with client.claim(["arm"], source="try") as claim:
            tick = claim.next_tick()
            wrist = floats(tick.joints.positions)[6]
            mode, rows, names = ControlMode.JOINT_VELOCITY, [[0.02]] * 4, ("panda_joint1",)
            if leaves_out:
                mode, rows, names = ControlMode.JOINT_POSITION, [[wrist]] * 4, ("panda_joint7",)
            verdict = claim.send(tick.number, claim.rows("arm", mode, rows, joints=names))
            ros.wait(lambda: seen.ticks[-1] > verdict.released_last + 3, "the rows to act")
        goals = [one[0] for one in ros.values("trajectory")[told:]]
    assert goals and min(goals) > moved - 0.01, "nothing of where it was before"
    assert abs(seen.first[-1] - moved) < 0.02


@contextmanager
def another_commander(options: dict[str, Any]) -> Iterator[Callable[[list[float]], None]]:
    """Somebody who moves the arm by its controller, as a pendant or MoveIt does."""
    node = RosNode(checked_model("options", Ros2Options, options), "pendant")
    sources = [JointSource(name, {name: 1.0}, has_effort=True) for name in JOINTS]
    topic = PartTopic(trajectory=options["parts"]["arm"]["trajectory"])
    drive = PartDrive(node, topic, range(7), sources, period_ns=10**9)
    yield lambda positions: drive.send(np.array([*positions, 0.0]))
    node.close()
