"""What the sentences are held against: one recorded episode, one simulator, a light robot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.live_robot import LiveRobot
from fairlead.deploy.registry import Registry
from fairlead.paths import repo_root
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.records.episode import Episode, record_episode

RECORDS_ORDER = ("right", "right_gripper", "base", "torso")


@pytest.fixture(scope="session")
def robot() -> RobotManifest:
    return load_robot("panda_mobile")


@pytest.fixture(scope="session")
def episode(tmp_path_factory: pytest.TempPathFactory) -> Episode:
    return record_episode(tmp_path_factory.mktemp("episode"))


@pytest.fixture(scope="session")
def backend() -> Iterator[RobosuiteBackend]:
    """The simulator with its parts in the order in which checkpoints write them."""
    made = RobosuiteBackend(SimulatorOptions(part_order=RECORDS_ORDER))
    yield made
    made.close()


@pytest.fixture(scope="module")
def light_robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRobot]:
    """The same four processes without physics, and without an object to see.

    For a module: a robot that waits takes a tenth of a core, as long as it is up.
    """
    folder: Path = tmp_path_factory.mktemp("light")
    options = ScratchOptions(pacing="lockstep", hal={"run": "hal_kinematic"})
    source = repo_root() / "compose" / "panda_mobile_sim.yaml"
    scratch = make_scratch(source, folder / "state", options)
    with scratch_robot(scratch, Registry(folder / "registry")) as running:
        yield LiveRobot(running)
