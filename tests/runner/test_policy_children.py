"""Processes that a policy started end with its own, in whatever session they are."""

from __future__ import annotations

import asyncio
import os
import select
import signal
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
import asyncio, sys
from tests.runner.test_policy_children import worker
asyncio.run(worker(sys.argv[1]).load())
"""
STARTS = pytest.mark.parametrize("starts", ["StartsAnother", "StartsASession"])


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


@STARTS
async def test_with_a_load_that_is_cancelled(child: Child, starts: str) -> None:
    policy = worker(f"{starts}AndNeverLoads")
    loading = asyncio.create_task(policy.load())
    await child.begins()
    loading.cancel()
    await asyncio.wait({loading})
    await child.ends()


@STARTS
@pytest.mark.parametrize("how", ["closed", "dies", "is killed"])
async def test_with_a_policy_that_was_loaded(child: Child, how: str, starts: str) -> None:
    policy = worker(starts)
    await policy.load()
    await child.begins()
    if how == "closed":
        await policy.close()
    elif how == "is killed":
        assert policy.pid is not None
        os.kill(policy_below(policy.pid), signal.SIGKILL)
        with pytest.raises(PolicyError, match="the process ended with status -9"):
            await policy.infer(Observation(tick=1, state=np.zeros(30), prompt=""))
    else:
        with pytest.raises(PolicyError, match="the process ended with status 7"):
            await policy.infer(Observation(tick=1, state=np.zeros(30), prompt=""))
    await child.ends()


@STARTS
async def test_with_a_runner_that_is_killed(child: Child, starts: str) -> None:
    words = (LOAD, f"{starts}AndNeverLoads")
    runner = await asyncio.create_subprocess_exec(sys.executable, "-c", *words)
    try:
        await child.begins()
    finally:
        runner.kill()
        await runner.wait()
    await child.ends()


async def test_with_a_keeper_that_is_killed_the_policy_ends(child: Child) -> None:
    policy = worker("StartsAnother")
    await policy.load()
    await child.begins()
    assert policy.pid is not None
    below = os.pidfd_open(policy_below(policy.pid))
    os.kill(policy.pid, signal.SIGKILL)
    assert await asyncio.to_thread(select.select, [below], [], [], WAIT_MS / 1000) != ([], [], [])
    os.close(below)
    await policy.close()


@pytest.mark.parametrize("how", ["closed", "asked"])
async def test_a_keeper_that_is_paused_keeps_nobody_waiting(child: Child, how: str) -> None:
    policy = worker("StartsAnother")
    await policy.load()
    await child.begins()
    assert policy.pid is not None
    os.kill(policy.pid, signal.SIGSTOP)
    async with asyncio.timeout(WAIT_MS / 1000):
        if how == "closed":
            await policy.close()
        else:
            with pytest.raises(PolicyError, match="the process ended with status 7"):
                await policy.infer(Observation(tick=1, state=np.zeros(30), prompt=""))
    await child.ends()


def policy_below(keeper: int) -> int:
    """The policy's own process, among what its keeper has adopted."""
    lists = Path(f"/proc/{keeper}/task").glob("*/children")
    [pid] = [
        int(one)
        for text in lists
        for one in text.read_text().split()
        if b"policy_process" in Path(f"/proc/{one}/cmdline").read_bytes()
    ]
    return pid
