"""A goal that is heard of no longer: it is ended all the same, or the robot is stopped."""

from __future__ import annotations

import pytest

from fairlead import Robot
from fairlead.errors import (
    FairleadError,
    MessageError,
    NoAnswerError,
    RefusedError,
    ServiceError,
    TransportError,
)
from fairlead.messages import Message
from fairlead.operate import goal as goal_module
from fairlead.operate import services as services_module
from fairlead.wire.bus import ReplyHandler
from tests.client.scripted_robot import DEPLOYMENT, GOAL_ID, ScriptedRobot, waiting_for
from tests.client.turns import turns

pytestmark = pytest.mark.asyncio


@pytest.mark.parametrize(
    ("lost", "kind"),
    [
        (NoAnswerError("no answer"), NoAnswerError),
        (TransportError("the session has closed"), TransportError),
        (None, MessageError),
    ],
)
async def test_a_goal_whose_acceptance_is_lost_has_the_robot_stopped(
    robot: Robot,
    scripted: ScriptedRobot,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    lost: FairleadError | None,
    kind: type[FairleadError],
) -> None:
    def lose(key: str, request: Message, timeout_s: float, on_reply: ReplyHandler) -> None:
        on_reply(b"no message" if lost is None else lost)

    monkeypatch.setattr(scripted.bus, "ask", lose)
    with pytest.raises(kind):
        await robot.run("s")
    assert scripted.stops
    assert "a protective stop holds the robot" in caplog.text


async def test_a_goal_that_is_refused_or_cannot_be_sent_stops_nobody(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(MessageError, match="cannot be sent"):
        await robot.run("s", deadline_ticks=2**64)
    refusal = RefusedError("runner", "another goal runs")
    monkeypatch.setattr(scripted.bus, "ask", lambda *asked: asked[-1](refusal))
    with pytest.raises(RefusedError):
        await robot.run("s")
    assert scripted.stops == []


async def test_a_runner_that_goes_away_is_an_error_that_names_its_log(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    task = await waiting_for(goal)
    scripted.tokens["runner"].undeclare()
    scripted.bus.declare_token(DEPLOYMENT.keys.alive("runner"))  # it is back at once
    with pytest.raises(ServiceError, match="runner went away .* see: fairlead logs runner$"):
        await task


async def test_a_link_that_breaks_for_a_moment_does_not_let_go_of_a_goal_that_goes_on(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    with pytest.raises(ServiceError, match="runner went away"):
        async with goal:
            scripted.say("running")
            scripted.tokens["runner"].undeclare()
            scripted.bus.declare_token(DEPLOYMENT.keys.alive("runner"))
            await goal.result()
    assert (scripted.cancelled, scripted.stops) == ([GOAL_ID], [])


@pytest.mark.parametrize(
    ("granted", "chunks", "stopped"),
    [
        pytest.param(["runner"], 1, True, id="it runs on, the link is cut"),
        pytest.param([], 0, True, id="it may still claim, the link is cut"),
        pytest.param(["planner"], 1, False, id="it is gone, and so is its claim"),
    ],
)
async def test_a_runner_that_stays_away_has_the_robot_stopped_unless_its_claim_is_over(
    robot: Robot,
    scripted: ScriptedRobot,
    monkeypatch: pytest.MonkeyPatch,
    granted: list[str],
    chunks: int,
    stopped: bool,
) -> None:
    monkeypatch.setattr(services_module.Services.wait_alive, "__kwdefaults__", {"timeout_s": 0.01})
    scripted.granted = granted
    goal = await robot.run("s")
    for seq in range(chunks):
        scripted.verdict(seq)
    await turns()
    scripted.tokens["runner"].undeclare()
    with pytest.raises(ServiceError, match="runner went away"):
        await goal.result()
    await goal.leave()
    assert (bool(scripted.stops), bool(goal.stopped)) == (stopped, stopped)


async def test_a_runner_that_falls_silent_is_given_up(
    robot: Robot, scripted: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(goal_module, "SILENCE_S", 0.0)
    goal = await robot.run("s")
    with pytest.raises(NoAnswerError, match="^runner: nothing said of the goal for 0 s; see: "):
        await goal.result()


async def test_a_goal_of_somebody_else_means_that_ours_has_ended_and_nobody_is_stopped(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    scripted.say("running")
    task = await waiting_for(goal)
    scripted.say("running", goal_id=GOAL_ID + 1)
    with pytest.raises(NoAnswerError, match="^runner has no longer this goal: it has ended, and"):
        await task
    await goal.leave()
    assert (scripted.cancelled, scripted.stops) == ([], [])


async def test_what_is_still_said_of_the_goal_before_ours_ends_nothing(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    scripted.say("ended", "succeeded", goal_id=GOAL_ID - 1)
    task = await waiting_for(goal)
    scripted.say("running")
    await turns()
    assert not task.done()
    scripted.say("ended", "failed")
    scripted.say("running", goal_id=GOAL_ID + 1)  # whoever reads late still has the result
    assert (await task).outcome == "failed"


async def test_a_runner_that_began_anew_has_ended_the_goal_and_nobody_is_stopped(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    goal = await robot.run("s")
    scripted.tokens["runner"].undeclare()
    scripted.forgot = True
    scripted.bus.declare_token(DEPLOYMENT.keys.alive("runner"))
    with pytest.raises(ServiceError, match="runner went away"):
        await goal.result()
    await goal.leave()
    assert (scripted.cancelled, scripted.stops, goal.stopped) == ([GOAL_ID], [], "")
