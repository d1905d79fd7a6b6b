"""A robot played by a script on the in-memory bus, and the client's handle on it."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from fairlead import Robot, connect
from tests.client.scripted_robot import DEPLOYMENT, ScriptedRobot


@pytest.fixture
def scripted() -> ScriptedRobot:
    return ScriptedRobot()


@pytest_asyncio.fixture
async def robot(scripted: ScriptedRobot) -> AsyncIterator[Robot]:
    async with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        yield robot
