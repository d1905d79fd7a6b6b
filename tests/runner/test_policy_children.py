"""Processes that a policy started end with its own."""

from __future__ import annotations

import asyncio
import os
import select
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import PolicyError
from fairlead.paths import repo_root
from fairlead.plugins import Plugin
from fairlead.policy import Observation
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policy_worker import PolicyWorker

pytestmark = [pytest.mark.processes, pytest.mark.asyncio]

WAIT_MS = 10_000
SKILL = "oracle-counter-to-cabinet"
LOAD = """
import asyncio
from tests.runner.test_policy_children import worker
asyncio.run(worker("StartsAnotherAndNeverLoads").load())
"""


def worker(name: str) -> PolicyWorker:
    where = f"tests.runner.broken_policies:{name}"
    return PolicyWorker(Plugin("policy backend", name, where, "the tests"), load_skill(SKILL), {})


class Child:
    """What holds the other end of a FIFO."""

    def __init__(self, fifo: Path) -> None:
        os.mkfifo(fifo)
        self.fifo = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
        self._poll = select.poll()
        self._poll.register(self.fifo, select.POLLIN)

    async def begins(self) -> None:
        assert await asyncio.to_thread(self._poll.poll, WAIT_MS), "it has not begun"
        assert os.read(self.fifo, 10) == b"\n"

    async def ends(self) -> None:
        assert await asyncio.to_thread(self._poll.poll, WAIT_MS), "it lives on"
        assert os.read(self.fifo, 10) == b""


@pytest.fixture
def child(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Child]:
    monkeypatch.setenv("PYTHONPATH", str(repo_root()), prepend=os.pathsep)
    monkeypatch.setenv("CHILD_WRITES", str(tmp_path / "fifo"))
    made = Child(tmp_path / "fifo")
    yield made
    os.close(made.fifo)


async def test_with_a_load_that_is_cancelled(child: Child) -> None:
    policy = worker("StartsAnotherAndNeverLoads")
    loading = asyncio.create_task(policy.load())
    await child.begins()
    loading.cancel()
    await asyncio.wait({loading})
    await child.ends()


@pytest.mark.parametrize("how", ["closed", "dies"])
async def test_with_a_policy_that_was_loaded(child: Child, how: str) -> None:
    policy = worker("StartsAnother")
    await policy.load()
    await child.begins()
    if how == "closed":
        await policy.close()
    else:
        with pytest.raises(PolicyError, match="the process ended with status 7"):
            await policy.infer(Observation(tick=1, state=np.zeros(30), prompt=""))
    await child.ends()


async def test_with_a_runner_that_is_killed(child: Child) -> None:
    runner = await asyncio.create_subprocess_exec(sys.executable, "-c", LOAD)
    try:
        await child.begins()
    finally:
        runner.kill()
        await runner.wait()
    await child.ends()
