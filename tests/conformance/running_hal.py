"""A HAL that runs alone, and what `fairlead hal check` finds of it."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.wire.session import ZenohBus
from fairlead_tools.conformance.hal_check import CheckOptions, HalCheck, ask_hal, check_hal
from fairlead_tools.supervisor.command_line import service_command
from tests.late_machine import is_busy
from tests.repo.tree import ROOT

START_S = 120.0
"""A simulator takes tens of seconds to start on a busy machine."""
END_S = 20.0
SHARE = 0.3
HOLD_S = 0.5


@dataclass(frozen=True)
class Wanted:
    """A HAL's line in a deployment file, its robot, what to check.

    Attributes:
        expected: whether this is what should be found.
    """

    robot: str
    hal: Mapping[str, Any]
    pacing: str = "realtime"
    only: tuple[str, ...] = ()
    expected: Callable[[HalCheck], bool] = lambda found: found.is_good


@dataclass(frozen=True)
class RunningHal:
    """Its deployment and its process. The deployment names a gate, which does not run."""

    file: Path
    deployment: Deployment
    process: subprocess.Popen[bytes]
    log: Path


@contextmanager
def running_hal(folder: Path, name: str, wanted: Wanted) -> Iterator[RunningHal]:
    """Start it, wait until it is ready, end it."""
    (folder / name / "state").mkdir(parents=True)
    spec = {
        "robot": wanted.robot,
        "id": name,
        "pacing": wanted.pacing,
        "services": {
            "hal": wanted.hal,
            "safety": {"run": "safety"},
        },
    }
    file, log = folder / name / "deployment.yaml", folder / name / "log"
    file.write_text(yaml.safe_dump(spec, sort_keys=False), encoding="utf-8")
    deployment = load_deployment(file)
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    with log.open("wb") as output:
        process = subprocess.Popen(
            service_command(file, deployment, "hal", folder / name / "state"),
            stdout=output, stderr=subprocess.STDOUT, env=environment,
        )  # fmt: skip
    try:
        wait_for(
            lambda: process.poll() is not None or b": ready\n" in log.read_bytes(), name, START_S
        )
        assert process.poll() is None, log.read_text()
        yield RunningHal(file, deployment, process, log)
    finally:
        process.terminate()
        process.wait(END_S)


def check_running(running: RunningHal, only: tuple[str, ...]) -> HalCheck:
    """What the command does, in this process."""
    hal = ask_hal(running.deployment)
    bus = ZenohBus(running.deployment.tool_endpoints("safety"))
    try:
        wish = CheckOptions(SHARE, HOLD_S, running.process.pid, "", is_simulator=True, only=only)
        return check_hal(bus, running.deployment, hal, wish, lambda text: None)
    finally:
        bus.close()


def check_all(folder: Path, wanted: Mapping[str, Wanted], at_once: int) -> dict[str, HalCheck]:
    """Every HAL by its name, several at a time."""

    def check(name: str, again: int = 2) -> HalCheck:
        with running_hal(folder / f"{again}", name, wanted[name]) as running:
            found = check_running(running, wanted[name].only)
        # A test that fails is given the same result again: so it is made again here.
        done = wanted[name].expected(found) or not is_busy() or not again
        return found if done else check(name, again - 1)

    with ThreadPoolExecutor(at_once) as pool:
        return dict(zip(wanted, pool.map(check, wanted), strict=True))


def rows_of(found: HalCheck, outcome: str) -> dict[str, str]:
    """What was got, by check and part."""
    rows = [row for row in found.rows if row.outcome == outcome]
    return {f"{row.check} {row.of}".rstrip(): row.got for row in rows}
