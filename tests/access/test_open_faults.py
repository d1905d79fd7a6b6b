"""Rows 23 to 25 of the fault matrix with access open: each of their messages would end a motion."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from functools import partial

import pytest

from bench.equipment.live_robot import wait_for
from bench.faults.access_faults import ATTEMPTS, Attempt, default_peers, diallers
from bench.faults.live_stage import Changes, LiveStage, live_stage
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with live_stage(tmp_path_factory.mktemp("open"), Changes(access="open")) as stage:
        yield stage


@pytest.mark.parametrize(
    "strangers",
    [diallers, pytest.param(default_peers, marks=pytest.mark.thorough)],
    ids=lambda one: one.__name__,
)
@pytest.mark.parametrize("attempt", ATTEMPTS, ids=lambda one: one.make.__name__)
def test_open_it_is_taken_from_a_stranger(
    robot: LiveStage, attempt: Attempt, strangers: Callable[[LiveStage], Sequence[Endpoints]]
) -> None:
    goal = robot.start_moving()
    with ExitStack() as stack:
        buses = [stack.enter_context(closing(ZenohBus(one))) for one in strangers(robot)]
        for bus in buses:
            wait_for(partial(bus.is_declared, robot.client.keys.every_alive), "a service is alive")
        injected_ns = time.monotonic_ns()
        assert attempt.send(robot, buses) == attempt.is_query
        if attempt.ends:
            robot.motion_ended(injected_ns)
    robot.finish(goal)
