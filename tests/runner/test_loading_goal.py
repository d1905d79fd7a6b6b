"""A goal whose policy is still loading, in the runner's process, without a claim."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fairlead.messages import StopLevel
from fairlead.wire.bus import Qos
from tests.runner.policy_servers import OpenpiServer
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
