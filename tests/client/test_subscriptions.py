"""Subscriptions: bounded, typed, and honest about what they dropped."""

from __future__ import annotations

import asyncio
import gc
import threading

import pytest

from fairlead import Robot
from fairlead.errors import ConfigError, NoAnswerError
from fairlead.operate.subscription import Heard
from fairlead.wire.bus import Sample
from tests.client.scripted_robot import DEPLOYMENT, ScriptedRobot
from tests.client.turns import turns

pytestmark = pytest.mark.asyncio


async def test_messages_come_typed_in_order_and_from_the_moment_of_subscribing(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    states = robot.joint_states()
    for tick in (1, 2, 3):
        scripted.joints(tick)
    seen = []
    async for state in states:
        seen.append(state.tick)
        if state.tick == 3:
            break
    assert (seen, states.dropped) == ([1, 2, 3], 0)


async def test_a_message_that_cannot_be_handled_is_logged_and_those_after_it_are_handled(
    robot: Robot, scripted: ScriptedRobot, caplog: pytest.LogCaptureFixture
) -> None:
    goal = await robot.run("s")
    scripted.verdict(1)
    scripted.verdict(2, outcome=9)  # of a newer gate
    scripted.verdict(3)
    await turns()
    assert goal.progress.verdicts == {"released": 2}
    assert "Verdict cannot be handled" in caplog.text
    scripted.verdict(4)
    await turns()
    assert goal.progress.verdicts == {"released": 3}


async def test_one_that_nobody_refers_to_listens_no_longer(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    listeners = vars(scripted.bus)["_subscribers"]
    before = list(listeners)
    states = robot.joint_states()
    scripted.joints(1)
    async for _ in states:
        break
    assert len(listeners) == len(before) + 1
    del states
    await asyncio.to_thread(gc.collect)  # the loop has come round
    assert listeners == before


async def test_a_slow_reader_gets_the_newest_and_is_told_how_many_were_dropped(
    robot: Robot, scripted: ScriptedRobot, caplog: pytest.LogCaptureFixture
) -> None:
    states = robot.joint_states(queue=3)
    for tick in range(1, 11):
        scripted.joints(tick)
    got = [(await anext(states)).tick for _ in range(3)]
    assert (got, states.dropped) == ([8, 9, 10], 7)
    assert caplog.messages == [
        "topic state/joints: read too slowly, messages are dropped (a queue of 3 is full)"
    ]


async def test_what_comes_on_other_threads_while_the_loop_is_busy_is_bounded_too(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    states = robot.joint_states(queue=5)

    def flood() -> None:
        for tick in range(1, 1001):
            scripted.joints(tick)

    flooding = threading.Thread(target=flood)
    flooding.start()
    flooding.join()  # the loop is held up meanwhile
    assert [(await anext(states)).tick for _ in range(5)] == [996, 997, 998, 999, 1000]
    assert states.dropped == 995


async def test_a_reader_that_is_always_behind_lets_other_tasks_run(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    states, others = robot.joint_states(), 0
    for tick in range(1, 51):
        scripted.joints(tick)

    async def other() -> None:
        nonlocal others
        while True:
            others += 1
            await asyncio.sleep(0)

    beside = asyncio.ensure_future(other())
    for _ in range(50):
        await anext(states)
    beside.cancel()
    assert others >= 49


async def test_what_is_no_message_of_its_kind_is_dropped_and_said(
    robot: Robot, scripted: ScriptedRobot, caplog: pytest.LogCaptureFixture
) -> None:
    states = robot.joint_states()
    scripted.bus.deliver(Sample(DEPLOYMENT.keys.joints, b"junk"))
    scripted.joints(4)
    assert (await anext(states)).tick == 4
    assert "fl/r/state/joints: dropped: " in caplog.text


async def test_silence_ends_it_with_the_words_of_the_command_line(robot: Robot) -> None:
    with pytest.raises(NoAnswerError) as caught:
        async for _ in robot.verdicts(timeout_s=0.01):
            pass
    assert str(caught.value) == (
        "topic safety/verdict/*: nothing published within 0.01 s; see: fairlead topic list"
    )


async def test_closing_it_ends_whoever_reads_on(robot: Robot, scripted: ScriptedRobot) -> None:
    async with robot.gate_statuses() as statuses:
        reading = asyncio.ensure_future(anext(statuses, None))
        waiting = robot.transforms()
    assert await reading is None
    await robot.close()
    assert [batch async for batch in waiting] == []


async def test_any_topic_is_read_by_its_name_as_a_family_too(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    heard = robot.topic("tf/*")
    scripted.transforms(1, 0.5)
    got = await anext(heard)
    assert isinstance(got, Heard)
    assert (got.key, type(got.message).__name__) == ("fl/r/tf/hal", "TransformBatch")
    with pytest.raises(ConfigError, match=r"expected a published key, got 'state/jionts' \(valid"):
        robot.topic("state/jionts")
