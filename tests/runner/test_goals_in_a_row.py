"""Goals that come as soon as the runner is free."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fairlead.errors import RefusedError
from tests.runner.scripted_world import ScriptedWorld

pytestmark = pytest.mark.processes


def test_each_result_is_said_though_the_next_goal_comes_at_once(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    world = make_world()
    world.start_runner({"backend": "constant", "options": {"row": [0.5] * 12}})
    goals = [world.start_goal()]
    for _ in range(8):
        world.cancel(goals[-1])
        goals.append(_as_soon_as_it_is_free(world))
    world.cancel(goals[-1])
    world.result(goals[-1])
    assert {f.goal_id for f in world.feedback if f.result is not None} == set(goals)


def _as_soon_as_it_is_free(world: ScriptedWorld) -> int:
    while True:
        try:
            return world.start_goal()
        except RefusedError as error:
            assert "still running" in str(error)
