"""``fairlead restart``: end one service of a running deployment, so that it starts anew."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.process_table import ProcessId
from fairlead.deploy.registry import Registry, Running
from fairlead.errors import ConfigError, NoAnswerError, ServiceError, expected
from fairlead.messages import GateState
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import RunningOption, choose_running
from fairlead_tools.cli.down import end_processes

EXAMPLE = "fairlead restart runner"
GRACE_S = 5.0
READY_TIMEOUT_S = 120.0  # as long as `fairlead up` waits
POLL_S = 0.05


def command(
    service: Annotated[str, typer.Argument(help="a service, as in `fairlead ps`")],
    deployment: RunningOption = None,
) -> None:
    """Restart one SERVICE that `fairlead up` runs, and wait until it is ready.

    Refused while a goal runs. An armed gate is disarmed first: it then ends cleanly.
    """
    entry = choose_running(deployment)
    old = _supervised_process(entry, service)
    _refuse_while_claimed(entry, service)
    end_processes([old], GRACE_S)
    pid = _wait_ready(entry.name, service, old)
    echo(f"restarted {service} of {entry.name} (pid {pid})")


def _supervised_process(entry: Running, service: str) -> ProcessId:
    if service not in entry.services:
        raise ConfigError(expected(entry.name, "a service that runs here", service, entry.services))
    found = entry.services[service]
    if found.by_hand or not entry.is_supervised:
        who = f"pid {found.running.pid}" if found.running else "its process is gone"
        raise ServiceError(
            f"{service}: `fairlead up` does not run it ({who}), so nobody would start it again; "
            f"end it, then: fairlead service {entry.deployment} {service}"
        )
    if found.running is None:
        raise ServiceError(f"{service}: is being started already; see: fairlead ps")
    return found.running


def _refuse_while_claimed(entry: Running, service: str) -> None:
    """A restart pulls the service from under whoever moves the robot; that is theirs to end."""
    with RobotClient(load_deployment(Path(entry.deployment)), by="fairlead restart") as client:
        try:
            gate = client.gate_status()
        except NoAnswerError:  # a gate that is dead grants nothing
            return
        if gate.claims:
            goals = ", ".join(f"{claim.source} runs {claim.skill}" for claim in gate.claims)
            raise ServiceError(
                f"{service}: a goal is being carried out ({goals}); end it first: Ctrl-C where "
                "it was started, or: fairlead disarm"
            )
        if service == client.gate and gate.state == GateState.ARMED:
            client.disarm()


def _wait_ready(name: str, service: str, old: ProcessId) -> int:
    deadline = time.monotonic() + READY_TIMEOUT_S
    while time.monotonic() < deadline:
        entry = Registry().find(name)
        found = entry.services.get(service) if entry is not None else None
        if found is None:
            raise ServiceError(f"{service}: {name} was ended meanwhile")
        if found.process != old and found.running and found.ready:
            return found.running.pid
        time.sleep(POLL_S)
    raise ServiceError(
        f"{service}: not ready after {READY_TIMEOUT_S:g} s; see: fairlead logs {service}"
    )
