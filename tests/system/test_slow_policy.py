"""A policy behind a server that answers too late for realtime: the goal says that it is slow."""

from __future__ import annotations

import re
import threading
from pathlib import Path

import numpy as np
import pytest

from fairlead.deploy.registry import Registry
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.runner.policy_servers import OpenpiServer, openpi_actions

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(180)]

SKILL, LATE_S = "oracle-counter-to-cabinet", 0.9
ROWS = np.zeros((8, 12), dtype=np.float32)


def test_a_refusal_for_age_says_how_long_the_policy_took_and_may_take(tmp_path: Path) -> None:
    waiting = threading.Event()

    def late(request: object, number: int) -> bytes:
        waiting.wait(LATE_S)  # the server's own slowness, which is what is tried
        return openpi_actions(ROWS)

    server = OpenpiServer(late)
    options = {"address": server.address, "start": "serve", "connect_timeout_s": 4,
               "answer_timeout_s": 4}  # fmt: skip
    policies = {SKILL: {"backend": "openpi", "options": options}}
    scratch = make_scratch(
        repo_root() / "compose" / "panda_mobile_sim.yaml",
        tmp_path / "state",
        ScratchOptions(pacing="realtime", options={"runner": {"policies": policies}}),
    )
    try:
        with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
            robot.client.arm()
            result = run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=60)).result
    finally:
        waiting.set()
        server.close()
    assert result is not None
    said = re.search(
        r"G006 .*: value (\d+), limit 10.*; the policy is slow: it answered after (\d\.\d\d) s and "
        r"has (\d\.\d\d) s: age_max_ticks, 10 of 50 ms, less the age of its inputs",
        result.detail,
    )
    assert said, result.detail
    assert int(said[1]) > 10
    assert float(said[2]) >= LATE_S
    assert float(said[3]) <= 0.5
