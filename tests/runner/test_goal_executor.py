"""What stands between the runner's threads and the core of a goal."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from fairlead.messages import ActionChunk, Heartbeat
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.memory_bus import MemoryBus
from fairlead_skill_runner.goal_executor import GoalExecutor
from fairlead_skill_runner.policy_worker import PolicyWorker
from fairlead_skill_runner.run_outputs import AskPolicy
from fairlead_skill_runner.trace import TraceWriter, read_trace
from tests.runner.scripted_robot import CLAIM, SKILL, joints, layout, setup, task


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


@pytest.mark.processes
@pytest.mark.asyncio
@pytest.mark.parametrize("seam", [None, {"blend_ticks": 3}])
async def test_the_trace_has_the_chunk_of_an_answer_whose_seam_is_blended(
    tmp_path: Path, seam: dict[str, int] | None
) -> None:
    skill = SkillManifest.model_validate(SKILL.model_dump(mode="json") | {"seam": seam})
    bus, sent = MemoryBus(), asyncio.Event()
    chunks: list[bytes] = []

    def hear(sample: Sample) -> None:
        chunks.append(sample.payload)
        sent.set()

    bus.subscribe("candidate", hear)
    candidate = bus.publisher("candidate", ActionChunk, Qos.HOT)
    worker = PolicyWorker(POLICIES.find("constant"), skill, {"row": [0.1] * 12})
    await worker.load()
    async with asyncio.TaskGroup() as tasks:
        trace = TraceWriter(tmp_path / "trace.jsonl")
        executor = GoalExecutor(setup(lockstep=False, skill=skill), worker, candidate, trace, tasks)
        for message in (task(10), joints(10), replace(layout(10), skill_hash=skill.skill_hash)):
            executor.deliver(message)
        await sent.wait()
        executor.cancel("the test")
    trace.close()
    await worker.close()
    [record] = read_trace(tmp_path / "trace.jsonl")
    assert record.chunk == (b"" if seam is None else chunks[0])
