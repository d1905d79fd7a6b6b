"""A robot and what it measures, for every test of the assembler."""

from __future__ import annotations

import pytest

from fairlead.robot import RobotManifest, load_robot
from tests.assembler.robot_feed import RobotFeed


@pytest.fixture(scope="session")
def robot() -> RobotManifest:
    return load_robot("panda_mobile")


@pytest.fixture
def feed(robot: RobotManifest) -> RobotFeed:
    return RobotFeed(robot)
