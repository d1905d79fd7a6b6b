"""The face for programs that block: the same code, and Ctrl-C ends what it waits for."""

from __future__ import annotations

import asyncio
import gc
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fairlead import RobotClient, connect
from fairlead.errors import ConfigError, MessageError, NoAnswerError, TransportError
from fairlead.operate.blocking import LoopThread
from fairlead.paths import STATE_VARIABLE, repo_root
from tests.client.scripted_robot import DEPLOYMENT, GOAL_ID, ScriptedRobot
from tests.client.turns import turns


@pytest.fixture
def robot(scripted: ScriptedRobot) -> Iterator[RobotClient]:
    with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        yield robot


@pytest.fixture
def thread() -> Iterator[LoopThread]:
    made = LoopThread()
    yield made
    made.close()


async def press_ctrl_c() -> None:
    """As a terminal does: Python hears it in its main thread, whichever thread raises it."""
    signal.raise_signal(signal.SIGINT)


def test_results_and_errors_come_back_to_the_caller(thread: LoopThread) -> None:
    async def fail() -> None:
        raise LookupError("x")

    async def succeed() -> str:
        return "done"

    assert thread.run(succeed()) == "done"
    with pytest.raises(LookupError, match="x"):
        thread.run(fail())


def test_ctrl_c_cancels_what_is_waited_for_and_waits_until_it_has_ended(
    thread: LoopThread,
) -> None:
    ended: list[str] = []

    async def work() -> None:
        try:
            await press_ctrl_c()
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            await turns()
            ended.append("cleaned up")
            raise

    with pytest.raises(KeyboardInterrupt):
        thread.run(work())
    assert ended == ["cleaned up"]


def test_each_further_ctrl_c_cancels_once_more(thread: LoopThread) -> None:
    count = 0

    async def stubborn() -> None:
        nonlocal count
        for _ in range(3):
            try:
                await press_ctrl_c()
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                count += 1

    with pytest.raises(KeyboardInterrupt):
        thread.run(stubborn())
    assert count == 3


def test_ctrl_c_just_before_it_begins_cancels_it_all_the_same(
    thread: LoopThread, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = vars(thread)["_loop"]
    tell = loop.call_soon_threadsafe
    begun: list[str] = []

    def press_first(function: Callable[[], None]) -> None:
        monkeypatch.setattr(loop, "call_soon_threadsafe", tell)
        signal.raise_signal(signal.SIGINT)
        tell(function)

    async def work() -> None:
        begun.append("begun")  # so that whatever cleans up does so
        await asyncio.Event().wait()

    monkeypatch.setattr(loop, "call_soon_threadsafe", press_first)
    with pytest.raises(KeyboardInterrupt):
        thread.run(work())
    assert begun == ["begun"]


def test_a_thread_that_waits_or_comes_while_it_is_closed_is_told_so() -> None:
    thread = LoopThread()
    ends, may_end = threading.Event(), threading.Event()
    said: list[BaseException] = []

    async def end_slowly() -> None:
        try:
            ends.set()
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            ends.set()
            await asyncio.to_thread(may_end.wait)
            asyncio.get_running_loop().create_task(asyncio.Event().wait())  # one more to end
            raise

    def call() -> None:
        try:
            thread.run(end_slowly())
        except BaseException as error:  # noqa: BLE001 - whatever it is
            said.append(error)

    def spawn(target: Callable[[], None]) -> threading.Thread:
        made = threading.Thread(target=target, daemon=True)
        made.start()
        return made

    waiting = spawn(call)
    ends.wait()
    ends.clear()
    closing = spawn(thread.close)
    ends.wait()  # it is being closed
    late = spawn(call)
    late.join(5.0)
    may_end.set()
    for one in (waiting, closing):
        one.join(5.0)
    assert [type(error) for error in said] == [TransportError, TransportError]
    assert not any(one.is_alive() for one in (waiting, closing, late))


def test_ctrl_c_while_it_waits_for_a_goal_cancels_the_goal(
    robot: RobotClient, scripted: ScriptedRobot
) -> None:
    with pytest.raises(KeyboardInterrupt), robot.run("s") as goal:
        for _ in goal:
            signal.raise_signal(signal.SIGINT)
    assert scripted.cancelled == [GOAL_ID]
    assert goal.progress.result is not None
    assert goal.stopped == ""


def test_a_goal_is_followed_with_for(robot: RobotClient, scripted: ScriptedRobot) -> None:
    goal = robot.run("s")
    scripted.say("running")
    phases = []
    for progress in goal:
        phases.append(progress.phase)
        scripted.say("ended", "succeeded")
    assert phases == ["running", "ended"]
    assert goal.result().outcome == "succeeded"


def test_messages_are_gone_through_with_for(robot: RobotClient, scripted: ScriptedRobot) -> None:
    states = robot.joint_states(queue=2)
    for tick in (1, 2, 3):
        scripted.joints(tick)
    found = iter(states)
    assert [next(found).tick, next(found).tick, states.dropped] == [2, 3, 1]
    assert states.next(0.01) is None


def test_a_subscription_ends_with_its_block_or_when_nobody_refers_to_it(
    robot: RobotClient, scripted: ScriptedRobot
) -> None:
    listeners = vars(scripted.bus)["_subscribers"]
    before = list(listeners)
    with robot.joint_states() as states:
        assert len(listeners) == len(before) + 1
    assert (listeners, states.next(10.0)) == (before, None)
    for _ in range(3):
        robot.joint_states().next(0.0)
    gc.collect()
    robot.joint_states().close()  # the loop has come round
    assert listeners == before


def test_it_may_be_used_from_several_threads(robot: RobotClient) -> None:
    replies: list[int] = []
    threads = [threading.Thread(target=lambda: replies.append(robot.arm().epoch)) for _ in range(8)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert len(replies) == 8


def test_a_bus_that_was_given_stays_open(scripted: ScriptedRobot) -> None:
    with connect(DEPLOYMENT, bus=scripted.bus):
        pass
    with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        assert robot.arm().epoch


def test_a_client_that_is_closed_says_so(scripted: ScriptedRobot) -> None:
    with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        pass
    with pytest.raises(TransportError, match="this client is closed; connect anew"):
        robot.gate_status()


def test_a_connection_that_is_entered_twice_gives_two_clients(scripted: ScriptedRobot) -> None:
    connection = connect(DEPLOYMENT, bus=scripted.bus)
    with connection as outer:
        with connection as inner:
            assert inner is not outer
        with pytest.raises(TransportError, match="closed"):
            inner.wait_alive()
        outer.wait_alive()
    with pytest.raises(TransportError, match="closed"):
        outer.wait_alive()


def test_a_number_that_no_message_takes_is_refused_before_anybody_is_asked(
    robot: RobotClient,
) -> None:
    with pytest.raises(MessageError, match="Goal: cannot be sent: "):
        robot.run("any", deadline_ticks=2**64)


def test_a_session_has_no_thread_that_its_closing_does_not_join(tmp_path: Path) -> None:
    # One that is left wakes up in a process that ends, which aborts it (exit code 134).
    text = (repo_root() / "compose" / "panda_mujoco.yaml").read_text(encoding="utf-8")
    file = tmp_path / "elsewhere.yaml"
    file.write_text(text.replace(":75", ":1"), encoding="utf-8")  # ports where nobody listens
    before = set(threading.enumerate())
    with connect(file):
        started = set(threading.enumerate()) - before
    assert {one.name for one in started} == {"fairlead client", "asyncio_0"}
    assert not [one for one in started if one.is_alive()]


def test_without_a_name_it_is_the_only_deployment_that_runs_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(STATE_VARIABLE, str(tmp_path))
    with pytest.raises(NoAnswerError, match="^no deployment runs on this machine; start one: "):
        connect()
    with pytest.raises(ConfigError, match="^deployment 'nowhere': no such file, and none of that"):
        connect("nowhere")
    assert connect("panda_mobile_sim") is not None


@pytest.mark.processes
def test_the_package_offers_connect_without_loading_what_it_needs() -> None:
    code = (
        "import sys, fairlead; print(sorted({'asyncio', 'numpy', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
