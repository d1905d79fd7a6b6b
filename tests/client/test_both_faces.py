"""The robot for programs on a loop and the one for programs that block offer the same."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import pytest

from fairlead import Robot, RobotClient, connect
from fairlead.robot.manifest import load_robot
from tests.client.scripted_robot import DEPLOYMENT, ScriptedRobot

ONLY_ON_A_LOOP = {
    "ask": "its methods ask; a message of one's own is for programs on a loop",
    "command": "its methods ask on the key of the person they act for",
    "open": "`connect` does it",
    "times_gone": "a goal asks it, to know whether its runner was away",
}
"""What `Robot` has and `RobotClient` has not, and why."""


@pytest.fixture
def robot(scripted: ScriptedRobot) -> Iterator[RobotClient]:
    with connect(DEPLOYMENT, bus=scripted.bus) as robot:
        yield robot


def test_each_method_has_a_namesake_that_takes_the_same(robot: RobotClient) -> None:
    def public(of: object) -> set[str]:
        return {name for name in dir(of) if name[0] != "_"}

    def parameters(of: type) -> dict[str, dict[str, inspect.Parameter]]:
        found = {name: getattr(of, name, None) for name in public(robot)}
        return {
            name: dict(inspect.signature(one).parameters)
            for name, one in found.items()
            if callable(one)
        }

    assert public(vars(robot)["_robot"]) - ONLY_ON_A_LOOP.keys() == public(robot)
    assert not ONLY_ON_A_LOOP.keys() & public(robot)
    assert {"arm", "cancel", "claim", "run", "stop", "topic"} <= parameters(RobotClient).keys()
    assert parameters(RobotClient) == parameters(Robot)


def test_a_stop_needs_no_reason(robot: RobotClient, scripted: ScriptedRobot) -> None:
    robot.stop()
    robot.stop("hand in the cell")
    assert [one.reason for one in scripted.stops] == ["operator", "hand in the cell"]


def test_its_robot_is_described(robot: RobotClient) -> None:
    assert robot.manifest == load_robot(robot.deployment.robot)
