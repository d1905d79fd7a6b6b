"""`run` directly after `up`: services on their first start are waited for, no others."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import pytest

from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead_tools.cli.running_deployments import wait_started

OWN = process_id(os.getpid())
assert OWN is not None
STARTING, READY = ServiceEntry(OWN, False, 0), ServiceEntry(OWN, True, 0)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "robot.yaml"


def entry(file: Path, **services: ServiceEntry) -> Running:
    assert OWN is not None
    return Running("robot", str(file), str(file.parent), OWN, services)


def test_services_that_start_are_named_and_waited_for_until_the_last_is_ready(
    tmp_path: Path, file: Path
) -> None:
    registry = Registry(tmp_path)
    registry.write(entry(file, hal=STARTING, safety=STARTING))
    after = iter((entry(file, hal=STARTING, safety=READY), entry(file, hal=READY, safety=READY)))
    said: list[str] = []

    def say(line: str) -> None:
        said.append(line)
        registry.write(next(after))

    wait_started(file, say, registry)
    assert said == ["waiting for hal, safety to start", "waiting for hal to start"]


@pytest.mark.parametrize(
    "service",
    [READY, dataclasses.replace(STARTING, restarts=1), dataclasses.replace(STARTING, process=None)],
)
def test_a_service_that_is_up_or_died_is_not_waited_for(
    service: ServiceEntry, tmp_path: Path, file: Path
) -> None:
    registry = Registry(tmp_path)
    registry.write(entry(file, hal=service))
    wait_started(file, pytest.fail, registry)


def test_another_deployment_that_starts_is_not_waited_for(tmp_path: Path, file: Path) -> None:
    registry = Registry(tmp_path)
    registry.write(entry(file, hal=STARTING))
    wait_started(tmp_path / "other.yaml", pytest.fail, registry)


def test_the_wait_is_bounded(tmp_path: Path, file: Path) -> None:
    registry = Registry(tmp_path)
    registry.write(entry(file, hal=STARTING))
    said: list[str] = []
    wait_started(file, said.append, registry, timeout_s=0.1)
    assert said == ["waiting for hal to start"]
