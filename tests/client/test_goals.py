"""A goal and the task that waits for it: neither outlives the other unsaid."""

from __future__ import annotations

import asyncio
import logging
import re
import time

import pytest

from fairlead import Robot, connect
from fairlead.errors import (
    ConfigError,
    NoAnswerError,
)
from fairlead.messages import GateState, StopLevel
from fairlead.operate import goal as goal_module
from tests.client.scripted_robot import DEPLOYMENT, GOAL_ID, ScriptedRobot, waiting_for
from tests.client.turns import turns, until

pytestmark = pytest.mark.asyncio


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


async def test_leaving_the_robot_waits_for_a_goal_that_a_cancelled_task_still_ends(
    scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "CANCEL_TIMEOUT_S", 0.01)
    scripted.confirms = False
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        goal = await robot.run("s")
        task = await waiting_for(goal)
        task.cancel()
        await until(lambda: scripted.cancelled)
    assert (len(scripted.cancelled), goal.is_over) == (1, True)
    assert "a protective stop holds the robot" in goal.stopped
    with pytest.raises(asyncio.CancelledError):
        await task


async def test_leaving_the_robot_ends_a_goal_that_was_sent_and_is_not_answered_yet(
    scripted: ScriptedRobot,
) -> None:
    scripted.answers_late = True
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        task = asyncio.ensure_future(robot.run("s"))
        await until(lambda: scripted.waiting)
        asyncio.get_running_loop().call_soon(scripted.answer)
    assert (scripted.cancelled, scripted.stops) == ([GOAL_ID], [])
    assert (await task).is_over


async def test_an_error_of_one_goal_does_not_keep_the_robot_from_ending_the_others(
    scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def fail() -> None:
        raise LookupError("x")

    with pytest.raises(LookupError, match="x"):
        async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
            monkeypatch.setattr(await robot.run("s"), "leave", fail)
            other = await robot.run("s")
    assert (scripted.cancelled, other.is_over) == ([GOAL_ID], True)


async def test_a_goal_is_listened_to_until_it_is_over_and_no_longer(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    listeners = vars(scripted.bus)["_subscribers"]
    before = list(listeners)
    goal = await robot.run("s")
    assert len(listeners) > len(before)
    scripted.say("ended", "succeeded")
    await goal.result()
    assert listeners == before
    assert (await goal.result()).outcome == "succeeded"
    await (await robot.run("s")).cancel()
    assert listeners == before
    task = await waiting_for(await robot.run("s"))
    task.cancel()
    await asyncio.wait({task})
    assert listeners == before
    scripted.tokens["runner"].undeclare()
    waiting = asyncio.ensure_future(robot.run("s"))
    await turns()
    waiting.cancel()
    await asyncio.wait({waiting})
    assert listeners == before


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


async def test_a_gate_that_holds_as_many_stops_as_it_can_is_stopped(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    scripted.lists_stops = False
    scripted.stops = [StopLevel(stop_id=number, by="", reason="") for number in range(1, 17)]
    asked = asyncio.ensure_future(robot.stop("one more"))
    while not asked.done():
        scripted.stops = scripted.stops[:16]  # this one finds no place
        scripted.lease(state=GateState.STOPPED)
        await asyncio.sleep(0.01)
    assert await asked == 16


async def test_no_name_keeps_a_stop_from_being_sent(scripted: ScriptedRobot) -> None:
    """A login name of other bytes, or a very long one."""
    for by in ("ad\udcff", "a" * 70_000):
        async with connect(DEPLOYMENT, by=by, bus=scripted.bus) as robot:
            stop_id = await robot.stop("hand in the cell")
        assert stop_id in {stop.stop_id for stop in scripted.stops}
