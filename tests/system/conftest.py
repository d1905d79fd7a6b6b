"""Whole robots as processes, each with its own ports, id, state folder and registry."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fairlead.operate.scratch_robot import scratch_robot
from fairlead.paths import repo_root
from fairlead.supervisor import Registry
from fairlead.supervisor.scratch import Scratch, ScratchOptions, make_scratch
from tests.system.light_hal import LIGHT_HAL, Pacing
from tests.system.live_robot import LiveRobot

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


@pytest.fixture(scope="session")
def registry(tmp_path_factory: pytest.TempPathFactory) -> Registry:
    return Registry(tmp_path_factory.mktemp("registry"))


@pytest.fixture
def light_scratch(tmp_path: Path) -> Callable[[Pacing], Scratch]:
    """Deployments without physics: commands are integrated, services are the real ones."""

    def make(pacing: Pacing) -> Scratch:
        options = ScratchOptions(pacing=pacing, options={"hal": LIGHT_HAL})
        return make_scratch(SOURCE, tmp_path / "state", options)

    return make


def _live(folder: Path, pacing: Pacing, registry: Registry) -> Iterator[LiveRobot]:
    scratch = make_scratch(SOURCE, folder, ScratchOptions(pacing=pacing))
    with scratch_robot(scratch, registry) as robot:
        yield LiveRobot(robot)


@pytest.fixture(scope="module")
def lockstep_robot(
    tmp_path_factory: pytest.TempPathFactory, registry: Registry
) -> Iterator[LiveRobot]:
    """One robot for a module's tests, in lockstep."""
    yield from _live(tmp_path_factory.mktemp("lockstep") / "state", "lockstep", registry)


@pytest.fixture(scope="module")
def realtime_robot(
    tmp_path_factory: pytest.TempPathFactory, registry: Registry
) -> Iterator[LiveRobot]:
    """One robot for a module's tests, at its own rate."""
    yield from _live(tmp_path_factory.mktemp("realtime") / "state", "realtime", registry)
