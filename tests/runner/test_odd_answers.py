"""What policies and their servers answer that is no answer: it ends a goal, never the runner."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.paths import repo_root
from tests.plugins.package import install
from tests.runner import broken_policies
from tests.runner.policy_servers import DEEP, OpenpiServer, openpi_actions
from tests.runner.scripted_world import ScriptedWorld

pytestmark = pytest.mark.processes

ODD = ("Dies", "HangsUp", "Huge", "Recurses", "TalksDeeply", "TalksMuch", "TalksOfRows")
ROWS = np.zeros((8, 12), dtype=np.float32)


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ScriptedWorld]:
    """Its runner finds the policies of `broken_policies` installed."""
    named = {name: f"{broken_policies.__name__}:{name}" for name in ODD}
    install(tmp_path / "site", "odd-policies", {"fairlead.policies": named}, {})
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path / "site"), str(repo_root())]))
    world = ScriptedWorld(tmp_path, pacing="lockstep")
    yield world
    world.close()


def two_goals_fail(world: ScriptedWorld) -> list[str]:
    """The runner is one process all the time: what each of two goals says of its policy."""

    def step() -> None:
        if world.claims:
            world.tick(5)

    details = []
    for _ in range(2):
        world.claims.clear()
        ended = world.result(world.start_goal(), every=step)
        assert ended.result is not None
        assert (ended.result.outcome, ended.result.kind) == ("failed", "policy_error")
        details.append(ended.result.detail)
    assert world.runner is not None and world.runner.poll() is None
    return details


@pytest.mark.parametrize("name", ODD)
def test_a_policy_s_odd_answer_fails_its_goal_and_the_next_is_run_by_the_same_runner(
    world: ScriptedWorld, name: str
) -> None:
    world.start_runner({"backend": name, "options": {}})
    for detail in two_goals_fail(world):
        assert detail.startswith("policy worker: "), detail


@pytest.mark.parametrize(
    "answer", [DEEP, bytearray(b"\x82\x7e\xff\xff" + DEEP[:1000])], ids=["deep", "half of one"]
)
def test_a_server_s_odd_answer_likewise(world: ScriptedWorld, answer: bytes | bytearray) -> None:
    def answers(request: Any, number: int) -> bytes | bytearray:
        return answer if number % 2 else openpi_actions(ROWS)  # each loading asks for rows first

    server = OpenpiServer(answers)
    try:
        options = {"address": server.address, "start": "serve", "connect_timeout_s": 4}
        world.start_runner({"backend": "openpi", "options": options | {"answer_timeout_s": 1}})
        for detail in two_goals_fail(world):
            assert detail.startswith("policy worker: inference failed: openpi policy: "), detail
        assert len(server.requests) == 4
    finally:
        server.close()
