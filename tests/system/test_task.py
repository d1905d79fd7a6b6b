"""The scripted expert does the whole task through the real processes."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from bench.equipment.live_robot import LiveRobot
from fairlead.messages import GoalResult, TaskState, decode
from fairlead.wire.bus import Sample

pytestmark = [pytest.mark.processes, pytest.mark.simulator]

REACHED_M = 0.10
REACHED_BY_TICK = 220
DRIVEN_M = 0.5
HELD_SEEDS = range(20)
FEWEST_SUCCESSES = 18


@dataclass(frozen=True)
class Episode:
    """How one goal went, by the task's own measurements.

    reached_at: ticks after the start when the gripper was first near the object, None: never.
    """

    result: GoalResult
    reached_at: int | None
    driven_m: float


def run_episode(robot: LiveRobot, seed: int) -> Episode:
    tasks: dict[int, TaskState] = {}

    def on_task(sample: Sample) -> None:
        task = decode(TaskState, sample.payload)
        tasks[task.tick] = task

    heard = robot.client.bus.subscribe(robot.client.keys.task, on_task)
    result = robot.run_goal(seed)
    heard.undeclare()
    metrics = {tick: dict(tasks[tick].metrics) for tick in tasks if tick >= result.first_tick}
    near = [t for t in metrics if metrics[t]["object_gripper_distance"] < REACHED_M]
    reached_at = min(near) - result.first_tick if near else None
    return Episode(result, reached_at, metrics[max(metrics)]["base_travel"])


@pytest.mark.timeout(300)
@pytest.mark.thorough
def test_the_expert_reaches_the_object_drives_and_puts_it_into_the_cabinet(
    lockstep_robot: LiveRobot,
) -> None:
    episode = run_episode(lockstep_robot, 7)
    assert (episode.result.outcome, episode.result.decided_by) == ("succeeded", "task"), episode
    assert episode.reached_at is not None and episode.reached_at <= REACHED_BY_TICK
    assert episode.driven_m > DRIVEN_M


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_twenty_held_seeds_all_reach_and_drive_and_at_least_eighteen_succeed(
    lockstep_robot: LiveRobot,
) -> None:
    episodes = {seed: run_episode(lockstep_robot, seed) for seed in HELD_SEEDS}
    for seed, episode in episodes.items():
        ticks = episode.result.last_tick - episode.result.first_tick
        print(
            f"seed {seed}: {episode.result.outcome} after {ticks} ticks, object reached at "
            f"{episode.reached_at}, base drove {episode.driven_m:.2f} m"
        )
    assert all(
        e.reached_at is not None and e.reached_at <= REACHED_BY_TICK for e in episodes.values()
    )
    assert all(episode.driven_m > DRIVEN_M for episode in episodes.values())
    succeeded = [seed for seed, e in episodes.items() if e.result.outcome == "succeeded"]
    assert len(succeeded) >= FEWEST_SUCCESSES, succeeded
