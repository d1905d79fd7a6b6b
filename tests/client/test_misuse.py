"""A program's own mistakes: each is one error of fairlead's, which says what would be right."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
from msgspec import structs

from fairlead import PartClaim, Robot, connect
from fairlead.errors import ClaimLostError, ConfigError, MessageError, TransportError
from fairlead.modes import ControlMode
from tests.client.scripted_robot import CLAIM_ID, DEPLOYMENT, ScriptedRobot
from tests.client.turns import turns, until

TWIST = ControlMode.BODY_TWIST
STILL = [[0.0] * 6] * 4

pytestmark = pytest.mark.asyncio


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (lambda claim: claim.rows("base", "body_twist", STILL), "modes, got 'body_twist'"),
        (lambda claim: claim.rows(["base"], TWIST, STILL), r"a part, got \['base'\] .valid"),
        (lambda claim: claim.rows("base", 7, STILL), "modes, got 7, no ControlMode .valid: "),
        (lambda claim: claim.rows("base", TWIST, [[0.0] * 6, [0, 0, math.nan, 0, 0, 0]]),
         "part base: expected finite numbers for body_twist, got nan in row 1, column 2$"),
        (lambda claim: claim.rows("base", TWIST, [[None] * 6]), "got rows of object$"),
        (lambda claim: claim.rows("base", TWIST, [["0.1"] * 6]), "got rows of <U3$"),
        (lambda claim: claim.rows("base", TWIST, [[True] * 6]), "got rows of bool$"),
        (lambda claim: claim.rows("base", TWIST, [[10**400] * 6]), "got rows of other things$"),
        (lambda claim: claim.rows("base", TWIST, np.ma.masked_array(STILL, mask=True)),
         "got a masked array$"),
        (lambda claim: claim.rows("base", TWIST, STILL, joints=None), "in a tuple, got None$"),
        (lambda claim: claim.rows("base", TWIST, [[1e309] * 6]), "got inf in row 0"),
    ],
)  # fmt: skip
async def test_rows_of_another_kind_are_refused_where_they_are_made(
    robot: Robot, rows: Callable[[Any], object], said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        rows(robot.claim(["base"], source="planner"))


async def test_what_is_sent_is_a_ticks_number_and_rows_of_this_library_no_more_than_a_gate_takes(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        scripted.lease()
        good = claim.rows("base", TWIST, STILL)
        long = claim.rows("base", TWIST, [[0.0] * 6] * 65)
        misused: Any = claim.send
        for tick in ("1", 1.5, -1, 2**64, None, True):
            with pytest.raises(ConfigError, match="^planner: expected the number of a tick, got "):
                await misused(tick, good)
        with pytest.raises(ConfigError, match=r"^planner: expected what `rows` made, got list$"):
            await misused(1, STILL)
        with pytest.raises(ConfigError, match="^planner: expected at most 64 rows, got 65$"):
            await claim.send(1, long)
        for changes in ({"mode": 77}, {"mode": "x"}, {"values": b"abc"}, {"values": None}):
            with pytest.raises(ConfigError, match="got a part of other bytes or mode$"):
                await misused(1, structs.replace(good, **changes))
        for timeout_s in (math.nan, math.inf, -1.0, None, "a"):
            with pytest.raises(ConfigError, match="^planner: expected a timeout in seconds, got "):
                await cast(Any, claim.next_tick)(timeout_s)


async def test_a_mode_that_the_running_hal_does_not_offer_is_refused_before_it_could_stop_it(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    switch = ControlMode.COMPOSITE_MODE
    claim = robot.claim(["base"], source="planner")
    claim.rows("composite", switch, [[1.0]])  # nobody has asked the HAL yet
    async with claim:
        scripted.lease()
        with pytest.raises(ConfigError, match="^part composite: expected a mode that this HAL off"):
            claim.rows("composite", switch, [[1.0]])


async def test_two_chunks_at_once_are_told_apart_by_refusing_the_second(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        scripted.lease()
        good = claim.rows("base", TWIST, STILL)
        first = asyncio.ensure_future(claim.send(1, good))
        await turns()
        with pytest.raises(ConfigError, match="one chunk after the other"):
            await claim.send(1, good)
        first.cancel()
        with pytest.raises(asyncio.CancelledError):
            await first
        second = asyncio.ensure_future(claim.send(1, good))
        await turns()
        assert not second.done()
        second.cancel()


@pytest.mark.parametrize(
    ("parts", "task", "said"),
    [
        ("arm", "", "expected a list of parts, got 'arm' "),
        (5, "", "expected a list of parts, got 5 "),
        (None, "", "expected a list of parts, got None "),
        ([["arm"]], "", "expected a part to claim, got "),
        (["arm"], 5, "expected a task in words, got 5"),
        (["arm"], "\udc80", "expected a task in words, got "),
    ],
)
async def test_a_claim_is_of_parts_and_for_a_task(
    robot: Robot, parts: Any, task: Any, said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        robot.claim(parts, source="planner", task=task)


async def outside(claim: PartClaim) -> None:
    with pytest.raises(ClaimLostError, match=r"^claim of planner: not held: .* `async with`"):
        await claim.next_tick()
    with pytest.raises(ClaimLostError, match="not held"):
        await claim.send(1, claim.rows("base", TWIST, STILL))


async def test_a_claim_outside_its_block_says_so_and_can_be_entered_then_and_again(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    claim = robot.claim(["base"], source="planner")
    await outside(claim)
    await claim.release()
    for tick in (1, 2):
        async with claim:
            scripted.lease()
            scripted.transforms(tick, 0.5)
            scripted.joints(tick)
            assert (await claim.next_tick()).number == tick
            scripted.lease(granted=tick == 2)  # the first is lost
            await turns()
        await outside(claim)
    assert scripted.released == [CLAIM_ID]


async def test_a_robot_that_is_closed_gives_back_what_its_claims_hold(
    scripted: ScriptedRobot,
) -> None:
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        claim = await robot.claim(["base"], source="planner").__aenter__()
    assert scripted.released == [CLAIM_ID]
    beats = scripted.beats
    await asyncio.wait({asyncio.ensure_future(until(lambda: scripted.beats > beats))}, timeout=0.2)
    assert scripted.beats == beats
    await claim.__aexit__(None, None, None)
    await outside(claim)


async def test_after_its_block_a_robot_says_that_it_is_closed(scripted: ScriptedRobot) -> None:
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        goal, claim = await robot.run("s"), robot.claim(["base"], source="planner")
    for asked in (robot.arm, robot.stop, lambda: robot.run("s"), claim.__aenter__, goal.cancel):
        with pytest.raises(TransportError, match="^this client is closed; connect anew$"):
            await asked()
    with pytest.raises(TransportError, match="closed"):
        robot.joint_states()
    await robot.close()
    assert not scripted.stops


async def test_without_a_block_a_connection_says_how_to_use_it(scripted: ScriptedRobot) -> None:
    unused: Any = connect(DEPLOYMENT, bus=scripted.bus)
    with pytest.raises(ConfigError, match=r"^connect: expected `with connect\(...\) as robot`"):
        unused.arm()
    assert not hasattr(unused, "_private")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"queue": 0}, "queue: expected a whole number from 1, got 0"),
        ({"queue": "x"}, "queue: expected a whole number from 1, got 'x'"),
        ({"timeout_s": math.nan}, "timeout_s: expected seconds, at least 0, got nan"),
        ({"timeout_s": -1}, "timeout_s: expected seconds, at least 0, got -1"),
        ({"timeout_s": None}, "timeout_s: expected seconds, at least 0, got None"),
    ],
)
async def test_a_subscription_that_could_hand_out_nothing_is_none(
    robot: Robot, scripted: ScriptedRobot, options: dict[str, Any], said: str
) -> None:
    with pytest.raises(ConfigError, match=f"^topic state/joints: {said}$"):
        robot.joint_states(**options)
    scripted.joints(1)


async def test_names_that_nobody_can_have_are_refused(robot: Robot) -> None:
    wrong: Any = robot
    for source in ("a b", "a/b", "", 5):
        with pytest.raises(ConfigError, match="^source: expected 1 to 64 of"):
            wrong.verdicts(source)
    with pytest.raises(ConfigError, match="^source: expected 1 to 64 of .*, got 5$"):
        wrong.claim(["base"], source=5)
    with pytest.raises(ConfigError, match=r"^topic: expected a published key, got '5' \(valid: "):
        wrong.topic(5)


async def test_fields_that_fit_no_message_are_named_before_anybody_is_asked(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    wrong: Any = robot
    for field, value, said in (
        ("deadline_ticks", -1, "Expected `int` >= 0"),
        ("prompt", 5, "Expected `str`, got `int`"),
        ("stall_timeout_s", "3", "Expected `float`, got `str`"),
    ):
        told = f"^Goal: cannot be sent: {said} - at `\\$.{field}`$"
        with pytest.raises(MessageError, match=told):
            await wrong.run("s", **{field: value})
    for wrong_id in ("1f", -1, None, True):
        with pytest.raises(MessageError, match=r"^Reset: cannot be sent: .* - at `\$.id`$"):
            await wrong.reset(wrong_id)
    assert not scripted.goals and not scripted.stops


async def test_no_reason_keeps_a_stop_from_being_sent(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    wrong: Any = robot
    await wrong.stop(5)
    await wrong.stop(None)
    assert {stop.reason for stop in scripted.stops} == {"5", "None"}


async def test_two_cancels_are_one(robot: Robot, scripted: ScriptedRobot) -> None:
    goal = await robot.run("s")
    first, second = await asyncio.gather(goal.cancel(), goal.cancel())
    assert first == second == await goal.cancel()
    assert not scripted.stops


async def test_who_closes_once_more_waits_for_the_claims_to_be_given_back() -> None:
    scripted = ScriptedRobot()
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        await robot.claim(["base"], source="planner").__aenter__()
        first = asyncio.ensure_future(robot.close())  # as the handler of a signal does
        await until(lambda: robot._closed is not None)
    assert scripted.released == [CLAIM_ID]
    await first


async def test_claims_are_given_back_by_a_task_that_is_cancelled_as_it_closes() -> None:
    scripted = ScriptedRobot()

    async def program() -> None:
        async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
            await robot.claim(["base"], source="planner").__aenter__()
            task = asyncio.current_task()
            assert task is not None
            asyncio.get_running_loop().call_soon(task.cancel)

    with pytest.raises(asyncio.CancelledError):
        await asyncio.ensure_future(program())
    assert scripted.released == [CLAIM_ID]


async def test_a_claim_that_is_held_is_not_taken_again(
    robot: Robot, scripted: ScriptedRobot
) -> None:
    claim = robot.claim(["base"], source="planner")
    async with claim:
        with pytest.raises(ConfigError, match="^claim of planner: held already"):
            await claim.__aenter__()


async def test_what_is_missing_before_the_block_is_missing_to_hasattr_too() -> None:
    assert not hasattr(connect(DEPLOYMENT, bus=ScriptedRobot().bus), "arm")


async def test_what_fails_at_the_end_is_a_note_of_the_programs_own_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def fails(robot: Robot) -> None:
        raise TransportError("no stop was confirmed")

    monkeypatch.setattr(Robot, "close", fails)
    with pytest.raises(ValueError, match="^mine\n") as caught:
        async with connect(DEPLOYMENT, bus=ScriptedRobot().bus):
            raise ValueError("mine")
    assert caught.value.__notes__ == ["and at the end of the robot's block: no stop was confirmed"]
    with pytest.raises(TransportError, match="^no stop was confirmed$"):
        async with connect(DEPLOYMENT, bus=ScriptedRobot().bus):
            pass
