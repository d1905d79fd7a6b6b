"""Services find each other in whatever order they are started."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import wait
from itertools import permutations

import pytest

from fairlead.operate.scratch_robot import scratch_robot
from fairlead.supervisor import Registry
from fairlead.supervisor.scratch import Scratch
from tests.system.light_hal import Pacing
from tests.system.live_robot import LiveRobot

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SERVICES = ("hal", "safety", "state_assembler", "runner")


@pytest.mark.parametrize("order", list(permutations(SERVICES)), ids=lambda order: "-".join(order))
def test_a_goal_moves_the_robot_after_any_start_order(
    light_scratch: Callable[[Pacing], Scratch], registry: Registry, order: tuple[str, ...]
) -> None:
    with scratch_robot(light_scratch("lockstep"), registry, list(order)) as robot:
        live = LiveRobot(robot)
        goal = live.start_moving()
        live.client.disarm()
        wait([goal], timeout=30.0)
        result = goal.result().result
        assert result is not None and result.kind == "claim_lost"
