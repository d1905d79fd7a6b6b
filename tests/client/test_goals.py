"""A goal and the task that waits for it: neither outlives the other unsaid."""

from __future__ import annotations

import asyncio
import logging
import re
import time
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from fairlead import Robot, RunningGoal, connect
from fairlead.errors import ConfigError, NoAnswerError, ServiceError
from fairlead.messages import GoalResult
from fairlead.operate import goal as goal_module
from tests.client.scripted_robot import DEPLOYMENT, GOAL_ID, ScriptedRobot
from tests.client.turns import turns, until

pytestmark = pytest.mark.asyncio


@pytest.fixture
def scripted() -> ScriptedRobot:
    return ScriptedRobot()


@pytest_asyncio.fixture
async def robot(scripted: ScriptedRobot) -> AsyncIterator[Robot]:
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        yield robot


async def waiting_for(goal: RunningGoal) -> asyncio.Task[GoalResult]:
    """A task that waits for the result, and does so already."""
    task = asyncio.ensure_future(goal.result())
    await turns()
    return task


async def test_progress_is_told_at_each_change_until_the_result(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s", prompt="go", deadline_ticks=9)
    assert (scripted.goals[0].prompt, scripted.goals[0].deadline_ticks) == ("go", 9)
    phases = []
    scripted.say("loading")
    async for progress in goal:
        phases.append(progress.phase)
        if progress.phase == "loading":
            scripted.say("running")
        elif progress.phase == "running":
            scripted.say("ended", "succeeded")
    assert phases == ["loading", "running", "ended"]
    assert (await goal.result()).outcome == "succeeded"
    assert scripted.cancelled == []


async def test_a_goal_that_failed_is_a_result_and_no_error(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    scripted.say("ended", "failed")
    assert (await goal.result()).outcome == "failed"


async def test_who_is_cancelled_while_waiting_cancels_the_goal(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    task = await waiting_for(goal)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert scripted.cancelled == [GOAL_ID]
    assert (goal.progress.result is not None, goal.stopped) == (True, "")
    assert scripted.stops == []


async def test_a_timeout_around_the_goal_cancels_it_too(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(goal.result(), 0.01)
    assert scripted.cancelled == [GOAL_ID]


async def test_a_second_cancellation_stops_the_robot_and_says_how_to_go_on(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.confirms = False
    goal = await robot.run("s")
    task = await waiting_for(goal)
    task.cancel()
    await until(lambda: scripted.cancelled)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    [stop] = {stop.stop_id for stop in scripted.stops}
    assert goal.stopped == (
        "runner did not confirm that the goal ended: a protective stop holds the robot\n"
        f"  try: fairlead reset {stop:016x}"
    )


async def test_a_runner_that_does_not_confirm_in_time_has_the_robot_stopped(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "CANCEL_TIMEOUT_S", 0.01)
    scripted.confirms = False
    goal = await robot.run("s")
    with pytest.raises(NoAnswerError, match="^runner did not confirm within 0.01 s"):
        await goal.cancel()
    assert scripted.stops == []  # that is for whoever asked to decide
    task = await waiting_for(goal)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert "a protective stop holds the robot" in goal.stopped


async def test_where_no_stop_is_confirmed_either_it_says_that_the_robot_may_move(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "CANCEL_TIMEOUT_S", 0.01)
    scripted.confirms = scripted.lists_stops = False
    goal = await robot.run("s")
    async with goal:
        pass
    assert re.match(
        r"runner did not confirm that the goal ended, and no stop is confirmed: THE ROBOT MAY "
        r"MOVE: robot r: no lease lists the stop after 2 s: THE GATE IS NOT ANSWERING",
        goal.stopped,
    )
    assert len(scripted.stops) >= 10  # it was repeated


async def test_cancelled_while_the_goal_is_sent_it_is_ended_once_it_is_known_to_have_begun(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.answers_late = True
    task = asyncio.ensure_future(robot.run("s"))
    await until(lambda: scripted.waiting)
    task.cancel()
    await turns()
    assert scripted.cancelled == []
    scripted.answer()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert (scripted.cancelled, scripted.stops) == ([GOAL_ID], [])


async def test_cancelled_twice_while_the_goal_is_sent_the_robot_is_stopped_and_that_is_logged(
    robot: Robot, scripted: ScriptedRobot, caplog: pytest.LogCaptureFixture
) -> None:
    scripted.answers_late = True
    task = asyncio.ensure_future(robot.run("s"))
    await until(lambda: scripted.waiting)
    task.cancel()
    await turns()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert scripted.stops
    assert [r.levelno for r in caplog.records] == [logging.ERROR]
    assert "a protective stop holds the robot" in caplog.text


async def test_cancelled_while_a_runner_does_not_answer_the_robot_is_stopped_and_the_goal_ended(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "CANCEL_TIMEOUT_S", 0.01)
    scripted.answers_late = True
    task = asyncio.ensure_future(robot.run("s"))
    await until(lambda: scripted.waiting)
    task.cancel()
    await until(lambda: scripted.stops)
    scripted.lease()  # it lists the stop
    assert not task.done()
    scripted.answer()  # the goal has begun all the same: nobody waits for it any more
    with pytest.raises(asyncio.CancelledError):
        await task
    assert scripted.cancelled == [GOAL_ID]


async def test_a_runner_that_goes_away_is_an_error_that_names_its_log(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    task = await waiting_for(goal)
    scripted.tokens["runner"].undeclare()
    scripted.bus.declare_token(DEPLOYMENT.keys.alive("runner"))  # it is back at once
    with pytest.raises(ServiceError, match="runner went away .* see: fairlead logs runner$"):
        await task
    await goal.leave()
    assert (scripted.cancelled, scripted.stops) == ([], [])


async def test_a_runner_that_falls_silent_is_given_up(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "SILENCE_S", 0.0)
    goal = await robot.run("s")
    with pytest.raises(NoAnswerError, match="^runner: nothing said of the goal for 0 s; see: "):
        await goal.result()


async def test_a_program_that_was_paused_goes_on_with_its_goal(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    paused_s, now_s = [0.0], time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: now_s() + paused_s[0])
    goal = await robot.run("s")
    task = await waiting_for(goal)
    paused_s[0] = 60.0
    await turns()
    assert not task.done()
    scripted.say("ended", "succeeded")
    assert (await task).outcome == "succeeded"


async def test_leaving_the_robot_ends_its_goals(scripted: ScriptedRobot) -> None:
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        await robot.run("s")
    assert scripted.cancelled == [GOAL_ID]


async def test_leaving_the_block_of_a_goal_that_has_ended_asks_nobody(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    async with await robot.run("s") as goal:
        scripted.say("ended", "succeeded")
        await goal.result()
    assert scripted.cancelled == []


async def test_a_runner_that_is_none_is_refused_with_those_there_are(robot: Robot) -> None:
    with pytest.raises(ConfigError, match=r"expected a runner, got 'hal' \(valid: runner\)$"):
        await robot.run("s", runner="hal")
