"""``fairlead service``, ``router``, ``restart``: one process of a deployment."""

from __future__ import annotations

import asyncio
import logging
import os
import shlex
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.access_warnings import warn_daily
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.process_table import ProcessId, process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry, running_name
from fairlead.deploy.service_manager import NOTIFY_VARIABLE, say_alive, say_ready
from fairlead.deploy.shared_router import router_endpoints
from fairlead.deploy.stop_signals import StopSignals
from fairlead.errors import ConfigError, NoAnswerError, ServiceError, TransportError, expected
from fairlead.log_output import LogOutput
from fairlead.messages import GateState
from fairlead.operate.asker import check_person
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import load_robot
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.lingering import forbid_lingering
from fairlead.wire.session import ZenohBus
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.options import (
    DeploymentArgument,
    DeploymentsArgument,
    NewStateOption,
    RunningOption,
    StateDirOption,
    choose_running,
    example,
)
from fairlead_tools.cli.processes import end_processes
from fairlead_tools.supervisor.command_line import (
    new_state_command,
    service_command,
    service_environment,
)
from fairlead_tools.supervisor.this_host import check_places_free, choose_host
from fairlead_tools.writable import require_writable


@example("fairlead service panda_mujoco hal")
def one_service_command(
    deployment: DeploymentArgument,
    service: Annotated[str, typer.Argument(help="a service's name in that file")],
    state_dir: StateDirOption = None,
    new_state: NewStateOption = False,
) -> None:
    """Run one SERVICE in the foreground, in any order with the others; `up` runs all of them.

    The process becomes the service's own: signals and exit status are its. Nobody starts it
    again when it dies.
    """
    loaded = load_deployment(deployment)
    if service not in loaded.services:
        raise ConfigError(
            expected(f"deployment {loaded.id}", "a service of it", repr(service), loaded.services)
        )
    host = choose_host(loaded, loaded.services[service].host or None)
    name = running_name(loaded, host)
    _refuse_second(name, service)
    check_places_free(loaded, [service])
    folder = (state_dir or Registry().default_state_dir(name)).absolute()
    build = new_state_command() if new_state else service_command
    words = build(deployment.absolute(), loaded, service, folder / service)
    os.umask(0o077)  # what robots do is nobody else's to read
    (folder / service).mkdir(parents=True, exist_ok=True)
    own, is_managed = process_id(os.getpid()), NOTIFY_VARIABLE in os.environ
    entry = {service: ServiceEntry(own, False, 0, by_hand=True, managed=is_managed)}
    running = Running(name, str(deployment.absolute()), str(folder), None, entry)
    try:
        Registry().write_by_hand(service, running, service == loaded.only("safety"))
    except OSError as error:  # a full disk: it runs, and is not listed
        echo(f"WARNING {name}: {error}; `fairlead ps` will not list {service}", err=True)
    os.execvpe(words[0], words, service_environment())  # noqa: S606 - the command is ours


def _refuse_second(name: str, service: str) -> None:
    entry = Registry().find(name)
    running = entry.services[service].running if entry and service in entry.services else None
    if running is not None:
        raise ServiceError(
            f"{service} of {name} runs already (pid {running.pid}); end it first: "
            f"fairlead down {name}"
        )


@example("fairlead router ./left.yaml ./right.yaml")
def router_command(
    deployments: DeploymentsArgument,
    as_json: Annotated[
        bool,
        typer.Option(
            "--json",
            "--print-config",
            help="print the Zenoh configuration instead, as zenohd reads it",
        ),
    ] = False,
) -> None:
    """Run the router of one robot or several in the foreground, on its host.

    `up` there starts that of its one robot, but with `--without router`. Zenoh's own `zenohd` can
    run in its place, with the configuration that --print-config prints and ZENOH_RUNTIME="(acc:
    (worker_threads: 16), rx: (worker_threads: 8))". It may crash, as may a service with a
    ZENOH_RUNTIME of your own: Zenoh 1.10 uses a TLS link from two threads without a lock (its
    issue 2557).
    """
    loaded = [load_deployment(file) for file in deployments]
    endpoints = router_endpoints(loaded)
    if as_json:
        print_json(endpoints.config())
        return
    for one in loaded:
        choose_host(one, one.routed.host)
        check_places_free(one, [ROUTER])
    asyncio.run(_serve(endpoints, loaded))


async def _serve(endpoints: Endpoints, deployments: Sequence[Deployment]) -> None:
    """Route until asked to stop; all of it happens in Zenoh's own threads."""
    logging.basicConfig(level=logging.INFO, handlers=[LogOutput()])
    signals, log = StopSignals("router"), logging.getLogger(ROUTER)
    bus = ZenohBus(endpoints)
    signals.started()
    log.info("listens on %s", ", ".join(one.router_endpoint for one in deployments))
    log.info("ready")
    say_ready()
    ports = [one.routed.port for one in deployments]
    beside = forbid_lingering(*ports), say_alive(), warn_daily(deployments, log)
    tasks = [asyncio.create_task(one) for one in beside]
    await signals.stopping.wait()
    for task in tasks:
        task.cancel()
    bus.close()


GRACE_S = 5.0
READY_TIMEOUT_S = 120.0  # as long as `fairlead up` waits
POLL_S = 0.05


@example("fairlead restart runner")
def restart_command(
    service: Annotated[str, typer.Argument(help="a service, as in `fairlead ps`")],
    deployment: RunningOption = None,
) -> None:
    """Restart one SERVICE that `fairlead up` runs, and wait until it is ready.

    Refused while a goal runs. An armed gate is disarmed first: it then ends cleanly.
    """
    entry = choose_running(deployment)
    old = _supervised_process(entry, service)
    load_robot(load_deployment(Path(entry.deployment)).robot)  # what would not start goes on
    require_writable(f"restart {service}", Registry().folder)  # there `up` says that it is ready
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
            f"end it, then: fairlead service {shlex.quote(entry.deployment)} {service}"
        )
    _refuse_while_paused(entry, service)
    if found.running is None:
        raise ServiceError(f"{service}: is being started already; see: fairlead ps")
    return found.running


def _refuse_while_paused(entry: Running, service: str) -> None:
    if entry.supervisor is not None and entry.supervisor.is_paused:
        pid = entry.supervisor.pid
        raise ServiceError(
            f"{service}: `fairlead up` (pid {pid}) is paused, so it would not start it again; "
            f"let it go on: kill -CONT {pid}"
        )


def _refuse_while_claimed(entry: Running, service: str) -> None:
    """A restart pulls the service from under whoever moves the robot; that is theirs to end.

    A router may let nobody in any more: a new certificate may be why it is started.
    """
    check_person()
    try:
        opened = RobotClient(load_deployment(Path(entry.deployment)), by="fairlead restart")
    except (ConfigError, TransportError) as error:
        if service != ROUTER:
            raise
        echo(f"WARNING nobody could be asked whether a goal runs: {error}", err=True)
        return
    with opened as client:
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
    began: set[ProcessId | None] = {old, None}
    while time.monotonic() < deadline:
        entry = Registry().find(name)
        found = entry.services.get(service) if entry is not None else None
        if entry is None or found is None:
            raise ServiceError(f"{service}: {name} was ended meanwhile")
        _refuse_while_paused(entry, service)
        if found.process != old and found.running and found.ready:
            return found.running.pid
        began.add(found.process)
        if len(began) > 3:
            raise ServiceError(
                f"{service}: it ended as it started, and is started again; "
                f"see: fairlead logs {service}"
            )
        time.sleep(POLL_S)
    raise ServiceError(
        f"{service}: not ready after {READY_TIMEOUT_S:g} s; see: fairlead logs {service}"
    )
