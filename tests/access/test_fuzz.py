"""Bytes that nobody means, from a second program that has a name: nobody falls over, nothing moves.

Each name dials each service that it may dial, and sends on every key that it may write: messages of
that and other kinds, changed, cut, glued together, too deep and too long. Access is open: closed, a
service has one link. `test_routed_fuzz` does the same with certificates.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import closing

import pytest

from bench.equipment.live_robot import LiveRobot
from fairlead.deploy.access import rights
from fairlead.paths import deployment_path
from fairlead.wire.endpoints import Endpoints
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.access.spoiled import (
    STILL_RAD,
    ask,
    check_all_go_on,
    measured,
    session_of,
    spoiled,
)

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SKILL = "panda-joint-reach"
NAMES = ("safety", "state_assembler", "runner", "operator")
EACH_KEY = 60


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRobot]:
    folder = tmp_path_factory.mktemp("fuzz")
    scratch = make_scratch(
        deployment_path("panda_mujoco"), folder / "state", ScratchOptions(access="open")
    )
    with scratch_robot(scratch) as robot:
        yield LiveRobot(robot, SKILL)


@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_name_sends_all_services_go_on(live: LiveRobot, name: str) -> None:
    deployment = live.robot.scratch.deployment
    parties = deployment.parties
    before = measured(live)
    chance = random.Random(name)
    sent = 0
    for service in (one for one in parties.services if parties.dials(name, one)):
        keys = {
            (one.key.replace("*", "thing"), one.kind)
            for one in rights(parties)
            if name in one.write and service in one.read and one.kind != "token"
        }
        listen = deployment.listen(service)
        config = Endpoints(connect=[listen], mode="client").config()
        with closing(session_of(config)) as session:
            for key, kind in sorted(keys):
                for _, text in zip(range(EACH_KEY), spoiled(chance), strict=False):
                    if kind == "query":
                        ask(session, key, text)
                    else:
                        session.put(key, text)
                    sent += 1
    print(f"{name}: {sent} messages")
    assert sent >= EACH_KEY
    assert measured(live) == pytest.approx(before, abs=STILL_RAD), "nothing moved"
    check_all_go_on(live)


def test_it_came_and_after_all_of_that_a_goal_succeeds(live: LiveRobot) -> None:
    assert dict(live.client.gate_status().counters)["G001"] > EACH_KEY / 2
    hal = (live.robot.scratch.state_dir / "logs/hal.log").read_text(encoding="utf-8")
    for message in ("SafeChunk", "Lease", "StopLevel"):
        assert f"ignored: {message} that cannot be read" in hal
    live.ready_to_move()
    result = live.start_goal().result(120.0).result
    assert result is not None and result.outcome == "succeeded"
