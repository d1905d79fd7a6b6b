"""Robots that share one router: of each the shipped HAL without physics, a real gate, a feeder."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import yaml

from bench.equipment.motion_log import MotionLog
from bench.scale.links import counted
from bench.scale.measured import Tick, Window
from bench.scale.processes import Process, Spending, ended, settle, spending
from bench.scale.traffic import Sent, sent
from fairlead.deploy.credentials import forget_secrets
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ServiceError
from fairlead.paths import repo_root
from fairlead_tools.certificates.authority import Authority
from fairlead_tools.supervisor.command_line import service_command, service_environment
from fairlead_tools.supervisor.this_host import free_ports

ROBOT, HOST = "so101", "here"
SERVICES = {"hal": "hal_kinematic", "safety": "safety"}
READY_S = 120.0


class RobotProcesses:
    """One robot, whose parties are clients of the router with certificates of their own.

    Args:
        priority: of HAL and gate; 0: they are ordinary processes.
    """

    def __init__(self, number: int, port: int, folder: Path, priority: int) -> None:
        self._folder = folder / f"robot{number}"
        self._folder.mkdir(parents=True)
        self.file = self._folder / "deployment.yaml"
        own = {"host": HOST, "realtime_priority": priority}
        content = {
            "robot": ROBOT, "id": f"scale{os.getpid()}_{number}", "pacing": "realtime",
            "hosts": {HOST: "127.0.0.1"}, "router": {"host": HOST, "port": port},
            "services": {name: {"run": run, **own} for name, run in SERVICES.items()},
        }  # fmt: skip
        self.file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        self.deployment = load_deployment(self.file)
        Authority(self.deployment).new(datetime.now(UTC), days=1)
        self.processes: list[Process] = []
        self._motion = MotionLog(self._folder / "hal")

    def start(self) -> None:
        """HAL, gate and feeder; they wait for their router."""
        for name in SERVICES:
            state = self._folder / name
            state.mkdir()
            self._start(name, service_command(self.file, self.deployment, name, state))
        self._start("feeder", [sys.executable, "-m", "bench.scale.feeder", str(self.file)])

    def _start(self, name: str, words: Sequence[str]) -> None:
        log = self._folder / f"{name}.log"
        self.processes.append(Process(words, log, service_environment(), repo_root()))

    @property
    def moves(self) -> bool:
        """Whether the feeder's first chunk was released."""
        return self.processes[-1].has_said("moves")

    def ticks(self, window: Spending) -> list[Tick]:
        """What its HAL did meanwhile, from its own log."""
        return [
            Tick(line.stamp_ns, line.lease_ns, line.moves)
            for line in self._motion.since(window.began_ns)
            if line.stamp_ns <= window.ended_ns
        ]


@contextmanager
def running(
    priority: int, count: int, folder: Path
) -> Iterator[tuple[Process, list[RobotProcesses]]]:
    """A router and robots, each with a port, an id and certificates of its own."""
    with ExitStack() as stack:
        robots = [
            RobotProcesses(number, port, folder, priority)
            for number, port in enumerate(free_ports(count))
        ]
        for one in robots:
            stack.callback(forget_secrets, one.deployment.keys)
        files = [str(one.file) for one in robots]
        processes: list[Process] = []
        stack.callback(ended, processes)
        for one in robots:
            one.start()
            processes += one.processes
        for process in processes:  # all have started before any of them ticks
            process.wait_for(partial(process.has_said, "router"), "waits for its router", READY_S)
        words = [sys.executable, "-m", "fairlead_tools.cli.main", "router", *files]
        router = Process(words, folder / "router.log", service_environment(), repo_root())
        processes.append(router)
        router.wait_for(partial(router.has_said, "ready"), "ready", READY_S)
        yield router, robots


def fairlead(priority: int, count: int, seconds: float, folder: Path) -> Window:
    """So many robots on one router, for so long."""
    with running(priority, count, folder) as (router, robots):
        settle("fairlead", lambda: sum(one.moves for one in robots), count)
        ports = [one.deployment.routed.port for one in robots]
        own = [one.pid for robot in robots for one in robot.processes]
        before = counted(ports)
        try:
            spent = spending({"robots": own, "router": [router.pid]}, seconds)
        except ServiceError:
            for process in (router, *(one for robot in robots for one in robot.processes)):
                process.wait_for(lambda: True, "runs", READY_S)  # who ended, with its last lines
            raise
        after = counted(ports)
        ticks = [one.ticks(spent) for one in robots]
    return Window(spent, ticks, after.a_second(before, count) if after and before else None)


def traffic(folder: Path) -> Mapping[str, Sent]:
    """What one robot sends, by key."""
    with running(0, 1, folder) as (_, robots):
        settle("fairlead", lambda: sum(one.moves for one in robots), 1)
        return sent(robots[0].deployment)
