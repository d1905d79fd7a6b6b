"""A robot and what it measures, for every test of the assembler."""

from __future__ import annotations

import pytest

from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView
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
    core = AssemblerCore(robot, Publishers())
    core.want(SkillView(SKILL))
    assert core.on_transforms(feed.static(1), "hal") == []
    return core
