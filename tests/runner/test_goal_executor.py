"""What stands between the runner's threads and the core of a goal."""

from __future__ import annotations

import asyncio

import pytest

from fairlead.messages import ActionChunk, Heartbeat
from fairlead.plugins import POLICIES
from fairlead.wire.bus import Qos
from fairlead.wire.memory_bus import MemoryBus
from fairlead_skill_runner.goal_executor import GoalExecutor
from fairlead_skill_runner.policy_worker import PolicyWorker
from tests.runner.scripted_robot import CLAIM, SKILL, setup


@pytest.mark.asyncio
async def test_what_is_raised_while_a_message_is_handled_ends_the_goal() -> None:
    candidate = MemoryBus().publisher("candidate", ActionChunk, Qos.HOT)
    worker = PolicyWorker(POLICIES.find("constant"), SKILL, {"row": [0.0] * 12})
    async with asyncio.TaskGroup() as tasks:
        executor = GoalExecutor(setup(lockstep=True), worker, candidate, None, tasks)
        await asyncio.to_thread(executor.deliver, Heartbeat(claim_id=CLAIM))
        assert executor.is_over
        with pytest.raises(TypeError, match="a goal takes no Heartbeat"):
            await executor.follow()
