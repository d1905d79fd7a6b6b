"""The scripted expert does the whole task through the real processes."""

from __future__ import annotations

import pytest

from fairlead.bus import Sample
from fairlead.messages import TaskState, decode
from tests.system.live_robot import LiveRobot

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

REACHED_M = 0.10
REACHED_BY_TICK = 220
DRIVEN_M = 0.5
QUICK = (0, 7, 13)
SEEDS = [pytest.param(n, marks=() if n in QUICK else pytest.mark.soak) for n in range(20)]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_expert_reaches_the_object_drives_and_puts_it_into_the_cabinet(
    lockstep_robot: LiveRobot, seed: int
) -> None:
    tasks: dict[int, TaskState] = {}

    def on_task(sample: Sample) -> None:
        task = decode(TaskState, sample.payload)
        tasks[task.tick] = task

    client = lockstep_robot.client
    heard = client.bus.subscribe(client.keys.task, on_task)
    result = lockstep_robot.run_goal(seed)
    heard.undeclare()

    assert (result.outcome, result.decided_by) == ("succeeded", "task"), result
    metrics = {tick: dict(tasks[tick].metrics) for tick in tasks if tick >= result.first_tick}
    near = [t for t in metrics if metrics[t]["object_gripper_distance"] < REACHED_M]
    assert near and min(near) - result.first_tick <= REACHED_BY_TICK
    assert metrics[max(metrics)]["base_travel"] > DRIVEN_M
