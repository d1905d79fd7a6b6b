"""How ``fairlead up`` ends: what failed is said, whatever comes meanwhile."""

from __future__ import annotations

import asyncio

import pytest

from fairlead.errors import RefusedError, ServiceError
from fairlead.operate.connection import connect
from fairlead.wire.bus import Answer
from fairlead_tools.cli.up import disarm_to_the_end
from tests.client.scripted_robot import DEPLOYMENT, ScriptedRobot
from tests.client.turns import turns


@pytest.mark.asyncio
async def test_ctrl_c_while_a_failed_up_disarms_does_not_hide_the_failure() -> None:
    asked: list[Answer] = []
    scripted = ScriptedRobot()
    scripted.gate.undeclare()
    scripted.bus.serve_later(
        DEPLOYMENT.keys.gate_status, "safety", lambda payload, answer: asked.append(answer)
    )
    said: list[str] = []

    async def up() -> None:
        async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
            try:
                raise ServiceError("runner: died")
            finally:
                await disarm_to_the_end(robot, lambda service, line: said.append(line))

    running = asyncio.create_task(up())
    await turns()
    running.cancel()
    await turns()
    assert asked and not running.done()
    asked[0](RefusedError("safety", "it ends"))
    with pytest.raises(ServiceError, match="runner: died"):
        await running
    assert said == ["could not disarm before stopping: safety refused: it ends"]
