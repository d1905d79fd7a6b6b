"""A robot and what it measures, for every test of the assembler."""

from __future__ import annotations

import pytest

from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_state_assembler.core import AssemblerCore
from tests.assembler.robot_feed import SKILL, RobotFeed


@pytest.fixture(scope="session")
def robot() -> RobotManifest:
    return load_robot("panda_mobile")


@pytest.fixture
def feed(robot: RobotManifest) -> RobotFeed:
    return RobotFeed(robot)


@pytest.fixture
def core(robot: RobotManifest, feed: RobotFeed) -> AssemblerCore:
    """Wants the oracle's layout, knows the static transforms, has seen no joints."""
    core = AssemblerCore(robot)
    core.want(SKILL)
    assert core.on_transforms(feed.static(1)) == []
    return core
