"""Whose joints may move at full size without a question: only simulators that say so."""

from __future__ import annotations

import pytest
from pydantic import BaseModel

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.hal.process import Equipment, HalDriver
from fairlead.paths import deployment_path
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.cli import hal


def deployment(name: str, run: str = "", profile: str = "sim") -> Deployment:
    found = load_deployment(deployment_path(name))
    hal = found.services[found.hal].model_copy(update={"run": run} if run else {})
    services = found.services | {found.hal: hal}
    return found.model_copy(update={"services": services, "profile": profile})


@pytest.mark.parametrize(
    ("name", "run"),
    [("so101_mujoco", ""), ("panda_mobile_sim", ""), ("so101_mujoco", "hal_kinematic")],
)
def test_simulators_that_ship_move_without_a_question(name: str, run: str) -> None:
    assert hal.is_simulator(deployment(name, run))


@pytest.mark.parametrize("run", ["hal_so101", "hal_ros2", "external"])
def test_hals_of_robots_and_programs_are_no_simulators_on_any_profile(run: str) -> None:
    assert not hal.is_simulator(deployment("so101_mujoco", run))


def test_a_simulator_under_limits_of_a_real_robot_is_none() -> None:
    assert not hal.is_simulator(deployment("so101_mujoco", profile="hardware"))


def test_a_driver_that_does_not_say_what_it_is_counts_as_a_robots(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hal, "hal_driver", lambda run, who: HalDriver(BaseModel, _equip))
    assert not hal.is_simulator(deployment("so101_mujoco"))


def _equip(robot: RobotManifest, profile: str, options: BaseModel) -> Equipment:
    raise ConfigError("nothing is equipped here")
