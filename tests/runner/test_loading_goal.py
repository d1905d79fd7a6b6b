"""Policies that load, in the runner's process: for a goal without a claim yet, or for the next."""

from __future__ import annotations

import resource
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from fairlead.errors import RefusedError
from fairlead.messages import BEING_LOADED, Done, Load, StopLevel, decode
from fairlead.wire.bus import Qos
from tests.runner.asked_policies import PI05
from tests.runner.policy_servers import OpenpiServer
from tests.runner.scripted_robot import SKILL
from tests.runner.scripted_world import ScriptedWorld

pytestmark = pytest.mark.processes


@pytest.mark.parametrize("how", ["cancelled", "stopped"])
def test_a_goal_is_ended_while_its_policy_loads(
    make_world: Callable[..., ScriptedWorld], how: str
) -> None:
    """After a stop and its reset nothing may begin that was asked for before."""

    def never(request: object, number: int) -> None:
        server.go_on.wait()

    world, server = make_world(), OpenpiServer(never)
    try:
        world.start_runner({"backend": "openpi", "options": {
            "address": server.address, "start": "serve", "connect_timeout_s": 4,
            "answer_timeout_s": 1}})  # fmt: skip
        goal = world.start_goal()
        world.wait_for(lambda: True if server.requests else None)
        if how == "cancelled":
            world.cancel(goal)
        else:
            stop = StopLevel(stop_id=7, by="test", reason="enough")
            world.bus.publisher(world.keys.stop, StopLevel, Qos.HOT).put(stop)
        by = "test" if how == "cancelled" else "test, who stopped the robot: enough"
        ended = world.result(goal)
        assert ended.result is not None
        assert (ended.result.outcome, ended.result.detail) == ("cancelled", f"cancelled by {by}")
        assert world.claims == []
    finally:
        server.close()


def with_another_skill(world: ScriptedWorld, server: str) -> ScriptedWorld:
    """Its runner, not yet started, offers PI05 as well, whose policy is at ``server``."""
    world.options |= {"skills": [SKILL.id, PI05], "servers": {PI05: server}}
    return world


def load(world: ScriptedWorld, skill: str) -> str:
    request = Load(skill=skill, by="test")
    return decode(Done, world.bus.query(world.keys.load("runner"), request, 10.0)).text


def wait_loaded(world: ScriptedWorld, skill: str) -> str:
    """What is said once it no longer loads."""
    return world.wait_for(
        lambda: None if (said := load(world, skill)).endswith(BEING_LOADED) else said
    )


def test_a_policy_is_loaded_while_a_goal_of_another_one_runs(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    def late(request: object, number: int) -> None:
        server.go_on.wait()

    server = OpenpiServer(late)
    world = with_another_skill(make_world(), server.address)
    try:
        world.start_runner({"backend": "constant", "options": {"row": [0.5] * 12}})
        goal = world.start_goal()
        assert load(world, PI05) == f"skill {PI05} is being loaded"
        world.wait_for(lambda: True if server.requests else None)
        server.go_on.set()
        with pytest.raises(RefusedError, match=f"skill {PI05} is not loaded: policy worker: load"):
            wait_loaded(world, PI05)
        assert load(world, SKILL.id) == f"skill {SKILL.id}: its policy answers the goal that runs"
        world.cancel(goal)
        world.result(goal)
        assert wait_loaded(world, SKILL.id) == f"skill {SKILL.id} is loaded"
        with pytest.raises(RefusedError, match="expected a skill on offer, got 'nothing'"):
            load(world, "nothing")
    finally:
        server.close()


def test_a_server_that_answers_the_goal_that_runs_is_not_asked_for_the_next(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    server = OpenpiServer(lambda request, number: None)
    world = with_another_skill(make_world(), server.address)
    try:
        world.start_runner({"backend": "openpi", "options": {"address": server.address}})
        goal = world.start_goal()
        assert load(world, PI05) == f"skill {PI05}: its policy answers the goal that runs"
        world.cancel(goal)
        world.result(goal)
    finally:
        server.close()


def test_a_policy_that_could_not_be_loaded_is_said_and_the_runner_goes_on(
    make_world: Callable[..., ScriptedWorld], tmp_path: Path
) -> None:
    world = with_another_skill(make_world(), "ws://127.0.0.1:9")  # nobody is there
    world.start_runner({"backend": "constant", "options": {"row": [0.5] * 12}})
    with pytest.raises(RefusedError, match=f"skill {PI05} is not loaded: policy worker: loading"):
        wait_loaded(world, PI05)
    log = tmp_path / "runner.log"
    said = f"skill {PI05} is not loaded: policy worker: loading failed"
    world.wait_for(lambda: True if said in log.read_text() else None)
    world.cancel(world.start_goal())


def test_a_load_for_which_there_is_no_room_ends_neither_the_runner_nor_its_goal(
    make_world: Callable[..., ScriptedWorld], tmp_path: Path
) -> None:
    world = with_another_skill(make_world(), "ws://127.0.0.1:9")  # nobody is there
    world.start_runner({"backend": "constant", "options": {"row": [0.5] * 12}})
    goal = world.start_goal(stall_timeout_s=60.0)
    world.wait_for(lambda: world.claims or None)  # its own policy has its files
    assert world.runner is not None
    pid = world.runner.pid
    open_files = len(list(Path(f"/proc/{pid}/fd").iterdir()))
    old = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    for room in range(8):  # as many as it takes to read the skill's files, and no more
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (open_files + room, old[1]))
        with suppress(RefusedError):
            load(world, PI05)
            break
    log, said = tmp_path / "runner.log", f"skill {PI05} is not loaded"
    world.wait_for(lambda: True if said in log.read_text() else None)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, old)
    world.cancel(goal)
    ended = world.result(goal).result
    assert ended is not None and ended.detail == "cancelled by test"
