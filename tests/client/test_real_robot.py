"""The client library on real services: the kinematic HAL, the gate, a runner, Zenoh."""

from __future__ import annotations

import asyncio
import math
import re
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import suppress

import pytest
import pytest_asyncio

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import LiveRobot
from fairlead import Robot, connect
from fairlead.deploy.registry import Registry
from fairlead.errors import ClaimLostError, ConfigError, NoAnswerError, RefusedError
from fairlead.messages import GateState, Hold, JointState, TransformBatch, Verdict
from fairlead.modes import ControlMode
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120), pytest.mark.asyncio]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"
FAR = "0 1.2 0"
STILL = [[0.0] * 6] * 8


@pytest.fixture(scope="module", params=["realtime"])
def live(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[LiveRobot]:
    folder = tmp_path_factory.mktemp("client")
    options = ScratchOptions(pacing=request.param, hal=LIGHT_HAL)
    scratch = make_scratch(SOURCE, folder / "state", options)
    with scratch_robot(scratch, Registry(folder / "registry")) as robot:
        yield LiveRobot(robot)


@pytest.fixture
def running(live: LiveRobot) -> ScratchRobot:
    """Armed at the start of a new episode, whatever the test before left."""
    live.ready_to_move()
    return live.robot


@pytest_asyncio.fixture
async def robot(running: ScratchRobot) -> AsyncIterator[Robot]:
    async with connect(running.scratch.file, by="test") as robot:
        yield robot


async def sources(robot: Robot) -> list[str]:
    return [claim.source for claim in (await robot.gate_status()).claims]


async def begun(goal: object) -> None:
    """Rows of the goal are released now."""
    async for progress in goal:  # type: ignore[attr-defined]
        if progress.verdicts.get("released", 0) > 1:
            return


async def test_a_goal_is_run_to_its_end_and_its_progress_told(robot: Robot) -> None:
    goal = await robot.run("go-to", prompt="0 0.1 0", deadline_ticks=600)
    phases = [progress.phase async for progress in goal]
    result = await goal.result()
    assert (result.outcome, result.decided_by) == ("succeeded", "policy"), result
    assert (phases[-1], goal.progress.verdicts["released"] > 3) == ("ended", True)


async def test_status_names_every_service_and_each_runners_goal(robot: Robot) -> None:
    status = await robot.status()
    assert status.missing == ()
    assert set(status.alive) == set(robot.deployment.services)
    assert status.gate is not None and status.gate.state == GateState.ARMED
    assert status.hal is not None and status.hal.pacing == "realtime"
    assert [runner.source for runner in status.runners] == ["navigation", "manipulation"]


async def test_a_cancelled_task_cancels_its_goal_and_the_parts_are_free(robot: Robot) -> None:
    goal = await robot.run("go-to", prompt=FAR)
    await begun(goal)
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.05):
            await goal.result()
    assert goal.progress.result is not None
    assert (goal.progress.result.outcome, goal.stopped) == ("cancelled", "")
    assert await sources(robot) == []


async def test_of_two_tasks_in_a_group_the_one_that_fails_ends_the_others_goal(
    robot: Robot,
) -> None:
    goal = await robot.run("go-to", prompt=FAR)

    async def fail() -> None:
        await begun(goal)
        raise LookupError("the map is gone")

    with pytest.raises(ExceptionGroup) as caught:
        async with asyncio.TaskGroup() as group:
            group.create_task(goal.result())
            group.create_task(fail())
    assert caught.group_contains(LookupError)
    assert goal.progress.result is not None and goal.progress.result.outcome == "cancelled"


async def test_a_stop_ends_goal_and_claims_and_is_reset_by_its_id(robot: Robot) -> None:
    goal = await robot.run("go-to", prompt=FAR)
    await begun(goal)
    stop_id = await robot.stop("test")
    result = await goal.result()
    assert (result.outcome, result.kind) == ("failed", "claim_lost")
    with pytest.raises(RefusedError) as refused:
        await robot.arm()
    assert refused.value.fix == f"fairlead reset {stop_id:016x}"

    measured = robot.joint_states()
    while (await robot.gate_status()).state != GateState.DISARMED:
        with suppress(RefusedError):  # not still yet
            await robot.reset(stop_id)
        await anext(measured)


async def test_a_claim_that_a_stop_ends_is_lost_with_the_stops_reason_and_what_to_try(
    robot: Robot,
) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        stop_id = await robot.stop("hand in the cell")
        said = f"the gate is stopped .*hand in the cell.*; try: fairlead reset {stop_id:016x}"
        with pytest.raises(ClaimLostError, match=f"claim of planner lost: {said}"):
            while True:
                await claim.next_tick()


async def test_subscriptions_are_typed_and_hear_the_robot(robot: Robot) -> None:
    states, transforms, statuses = (
        robot.joint_states(),
        robot.transforms(),
        robot.gate_statuses(),
    )
    first, second = await anext(states), await anext(states)
    assert isinstance(first, JointState) and second.tick == first.tick + 1
    assert isinstance(await anext(transforms), TransformBatch)
    assert (await anext(statuses)).state == GateState.ARMED
    verdicts = robot.verdicts("planner")
    async with robot.claim(["base"], source="planner") as claim:
        tick = await claim.next_tick()
        mine = await claim.send(tick.number, claim.rows("base", ControlMode.BODY_TWIST, STILL))
    heard = await anext(verdicts)
    assert isinstance(heard, Verdict) and heard.verdict_id == mine.verdict_id


async def test_a_claim_outlives_many_heartbeat_windows_and_its_rows_act(robot: Robot) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        tick = await claim.next_tick()
        ahead = claim.rows("base", ControlMode.BODY_TWIST, [[0.1, 0, 0, 0, 0, 0]] * 8)
        acted = 0
        began = tick.number
        base = robot.manifest.part_names.index("base")
        while tick.number < began + 40:  # 2 s: seven times what a claim lives without a beat
            await claim.send(tick.number, ahead)
            tick = await claim.next_tick()
            acted += tick.joints.acted[base].hold == Hold.NONE
        x, y, _ = tick.planar_pose("odom", "base_link")
        assert (acted > 20, math.hypot(x, y) > 0.05) == (True, True)
    assert await sources(robot) == []


def hold_up_this_loop(running: ScratchRobot) -> None:
    """Until the gate says that nobody has a claim: heard by a client with a loop of its own."""
    for status in running.client.gate_statuses():
        if not status.claims:
            return


async def test_a_program_that_holds_up_its_loop_loses_its_claim_by_name(
    running: ScratchRobot, robot: Robot
) -> None:
    async with robot.claim(["base"], source="planner") as claim:
        await claim.next_tick()
        hold_up_this_loop(running)
        with pytest.raises(ClaimLostError, match="claim of planner lost: the gate no longer "):
            while True:
                await claim.next_tick()


async def test_a_claim_that_another_holds_is_refused_with_its_holder(robot: Robot) -> None:
    async with robot.claim(["base"], source="planner", task="drive"):
        with pytest.raises(RefusedError, match=r"part base is held by planner \(drive\)"):
            async with robot.claim(["base"], source="other"):
                raise AssertionError("never held")


async def test_a_skill_that_nobody_has_is_refused_by_the_runner(robot: Robot) -> None:
    with pytest.raises(RefusedError, match="no-such-skill"):
        await robot.run("no-such-skill")


async def test_a_hand_over_to_a_runner_that_there_is_not_is_refused(robot: Robot) -> None:
    with pytest.raises(ConfigError, match="expected a runner, got 'nobody'"):
        await robot.run("go-to", prompt=FAR, hand_over_to="nobody")


async def test_ctrl_c_in_a_program_that_waits_for_its_goal_ends_the_goal(
    running: ScratchRobot, robot: Robot
) -> None:
    program = (
        "import asyncio, sys\n"
        "from fairlead import connect\n"
        "async def main():\n"
        "    async with connect(sys.argv[1]) as robot:\n"
        "        goal = await robot.run('go-to', prompt=sys.argv[2])\n"
        "        try:\n"
        "            async for now in goal:\n"
        "                if now.verdicts: print('moving', flush=True)\n"
        "        finally:\n"
        "            print(goal.progress.result.outcome, flush=True)\n"
        "asyncio.run(main())\n"
    )
    words = [sys.executable, "-c", program, str(running.scratch.file), FAR]
    started = await asyncio.create_subprocess_exec(*words, stdout=-1, stderr=-1)
    assert started.stdout is not None
    assert await started.stdout.readline() == b"moving\n"
    started.send_signal(signal.SIGINT)
    said, errors = await asyncio.wait_for(started.communicate(), 30.0)
    assert said.split()[-1] == b"cancelled", errors.decode()
    assert b"KeyboardInterrupt" in errors
    assert await sources(robot) == []


@pytest.mark.parametrize("live", ["lockstep"], indirect=True)
async def test_the_programs_of_the_document_run(running: ScratchRobot, robot: Robot) -> None:
    text = (repo_root() / "docs" / "client.md").read_text()
    example = repo_root() / "docs" / "examples" / "run_client.py"
    [first] = re.findall(r"```python\n(async def main.*?)```", text, re.S)
    assert first.strip() in example.read_text()
    await robot.disarm()
    words = [sys.executable, str(example), str(running.scratch.file), "go-to", "0 0.05 0"]
    done = await asyncio.to_thread(subprocess.run, words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert re.search(r"\nsucceeded: the base is at .*\nat tick \d+: \[", done.stdout), done.stdout
    done = await asyncio.to_thread(
        subprocess.run, [*words[:3], "goto", "0 0 0"], capture_output=True, text=True
    )
    assert done.returncode == 1 and done.stderr.startswith("ERROR "), done.stderr
    await robot.disarm()
    await robot.arm()
    blocking, claim = re.findall(r"```python\n((?:with|async with) .*?)```", text, re.S)
    names = {"deployment": running.scratch.file, "connect": connect}
    await robot.disarm()
    await asyncio.to_thread(exec, blocking.replace("0 0.3 0", "0 0.05 0"), names)
    assert names["result"].outcome == "succeeded"  # type: ignore[attr-defined]
    assert (await robot.gate_status()).state == GateState.DISARMED
    await robot.arm()
    body = "\n".join(f"    {line}" for line in claim.splitlines())
    names = {"robot": robot, "ControlMode": ControlMode}
    exec(f"async def program():\n{body}\n    return verdict\n", names)  # noqa: S102
    verdict = await names["program"]()  # type: ignore[operator]
    assert verdict.code == 0


async def test_a_robot_of_which_nobody_runs_is_said_as_the_commands_say_it(
    running: ScratchRobot,
) -> None:
    other = running.scratch.deployment.model_copy(update={"id": "nobody"})
    async with connect(other) as robot:
        with pytest.raises(NoAnswerError, match="^robot nobody: safety not seen within 3 s; is it"):
            await robot.arm()
        assert (await robot.status()).alive == ()
