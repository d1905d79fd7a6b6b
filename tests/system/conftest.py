"""Whole robots as processes, each with its own ports, id, state folder and registry."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL, Pacing
from bench.equipment.live_robot import LiveRobot
from fairlead.deploy.registry import Registry
from fairlead.paths import gate_binary, repo_root
from fairlead_tools.supervisor.scratch import Scratch, ScratchOptions, make_scratch, scratch_robot
from tests.repo.tree import files
from tests.system.wheel_environment import Person, built, install

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


@pytest.fixture(scope="session")
def registry(tmp_path_factory: pytest.TempPathFactory) -> Registry:
    return Registry(tmp_path_factory.mktemp("registry"))


@pytest.fixture
def light_scratch(tmp_path: Path) -> Callable[[Pacing], Scratch]:
    """Deployments without physics: commands are integrated, services are the real ones."""

    def make(pacing: Pacing) -> Scratch:
        options = ScratchOptions(pacing=pacing, hal=LIGHT_HAL)
        return make_scratch(SOURCE, tmp_path / "state", options)

    return make


def _live(folder: Path, options: ScratchOptions, registry: Registry) -> Iterator[LiveRobot]:
    with scratch_robot(make_scratch(SOURCE, folder, options), registry) as robot:
        yield LiveRobot(robot)


@pytest.fixture(scope="module")
def lockstep_robot(
    tmp_path_factory: pytest.TempPathFactory, registry: Registry
) -> Iterator[LiveRobot]:
    """One robot for a module's tests, in lockstep."""
    options = ScratchOptions(pacing="lockstep")
    yield from _live(tmp_path_factory.mktemp("lockstep") / "state", options, registry)


@pytest.fixture(scope="module")
def realtime_robot(
    tmp_path_factory: pytest.TempPathFactory, registry: Registry
) -> Iterator[LiveRobot]:
    """One robot without physics for a module's tests, at its own rate."""
    options = ScratchOptions(pacing="realtime", hal=LIGHT_HAL)
    yield from _live(tmp_path_factory.mktemp("realtime") / "state", options, registry)


@pytest.fixture(scope="session")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, the source archive and the lock file."""
    folder = tmp_path_factory.mktemp("dist")
    files()  # listed now: what is written while the tests run is in no archive
    built(folder, gate_binary().parent)
    return folder


@pytest.fixture(scope="session")
def wheel(dist: Path) -> Path:
    [path] = dist.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def person(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Person:
    """Somebody with the wheel in an environment that holds nothing else."""
    home = tmp_path_factory.mktemp("home")
    return Person(install(wheel, tmp_path_factory.mktemp("env")), home)
