"""Servers that answer as told, and workers whose policies ask them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from fairlead.plugins import POLICIES
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policy_worker import PolicyWorker
from tests.runner.asked_policies import Ask
from tests.runner.policy_servers import ANSWERS, OpenpiServer, RldxServer
from tests.runner.scripted_world import ScriptedWorld


@pytest.fixture
def closing() -> Iterator[list[Any]]:
    opened: list[Any] = []
    yield opened
    for one in reversed(opened):
        one.close()


@pytest.fixture
def openpi(closing: list[Any]) -> Callable[[ANSWERS], OpenpiServer]:
    def make(answers: ANSWERS) -> OpenpiServer:
        closing.append(OpenpiServer(answers))
        return closing[-1]  # type: ignore[no-any-return]

    return make


@pytest.fixture
def rldx(closing: list[Any]) -> Callable[[ANSWERS], RldxServer]:
    def make(answers: ANSWERS) -> RldxServer:
        closing.append(RldxServer(answers))
        return closing[-1]  # type: ignore[no-any-return]

    return make


@pytest_asyncio.fixture
async def worker() -> AsyncIterator[Ask]:
    workers: list[PolicyWorker] = []

    def make(skill_id: str, address: str, **options: float) -> PolicyWorker:
        skill = load_skill(skill_id)
        changed = skill.policy.options | {"address": address} | options
        workers.append(PolicyWorker(POLICIES.find(skill.policy.backend), skill, changed))
        return workers[-1]

    yield make
    for one in reversed(workers):
        await one.close()


@pytest.fixture
def make_world(tmp_path: Path) -> Iterator[Callable[..., ScriptedWorld]]:
    worlds: list[ScriptedWorld] = []

    def make(pacing: str = "lockstep") -> ScriptedWorld:
        worlds.append(ScriptedWorld(tmp_path, pacing=pacing))  # type: ignore[arg-type]
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()
