"""What stands between the runner's threads and the core of a goal."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from fairlead.messages import ActionChunk, Heartbeat
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.wire.bus import Qos
from fairlead.wire.memory_bus import MemoryBus
from fairlead_skill_runner.goal_executor import GoalExecutor
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_outputs import AskPolicy
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


@pytest.mark.asyncio
async def test_what_is_raised_while_the_policy_is_asked_ends_the_goal_and_no_other_task() -> None:
    candidate = MemoryBus().publisher("candidate", ActionChunk, Qos.HOT)
    worker = PolicyWorker(POLICIES.find("constant"), SKILL, {"row": [0.0] * 12})
    no_numbers = Observation(tick=5, state=np.array(["a"]), prompt="")
    async with asyncio.TaskGroup() as tasks:
        executor = GoalExecutor(setup(lockstep=True), worker, candidate, None, tasks)
        executor._ask(AskPolicy(call=1, observation=no_numbers))
        with pytest.raises(ValueError, match="could not convert string to float"):
            await executor.follow()
