"""``fairlead up``: start one host's services and keep them running."""

from __future__ import annotations

import os
import signal
import sys
import threading
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from fairlead.cli.console import hex_id
from fairlead.cli.deployment_choice import parse_deployment
from fairlead.cli.other_hosts import OtherHosts, router_reached
from fairlead.cli.status import state_and_cause
from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.errors import FairleadError, ServiceError
from fairlead.messages import GateState
from fairlead.operate.client import RobotClient
from fairlead.supervisor import Registry, ServiceEvent, Supervisor
from fairlead.supervisor.registry import running_name
from fairlead.supervisor.this_host import choose_host

EXAMPLE = "fairlead up panda_mobile_sim"
READY_TIMEOUT_S = 120.0  # a first start compiles and caches much on a slow machine
WATCH_S = 0.1


def command(
    deployment: Annotated[
        Path,
        typer.Argument(
            parser=parse_deployment, metavar="NAME_OR_FILE", help="a name in compose/, or a file"
        ),
    ],
    state_dir: Annotated[
        Path | None,
        typer.Option(
            file_okay=False, help="folder for logs and state; default: ~/.local/state/fairlead/ID"
        ),
    ] = None,
    order: Annotated[str, typer.Option(help="start order, comma-separated; any order works")] = "",
    host: Annotated[
        str | None, typer.Option(help="which host of the file this machine is, if it has several")
    ] = None,
    no_router: Annotated[
        bool, typer.Option("--no-router", help="the router runs by itself: fairlead router, zenohd")
    ] = False,
) -> None:
    """Start a deployment's services (on one host), print their logs, restart what dies.

    It runs until Ctrl-C. A deployment of several hosts is started once on each, with --host,
    in any order.
    """
    loaded = load_deployment(deployment)
    _ = loaded.hal, loaded.only("safety"), loaded.only("skill_runner")  # refused before a start
    host = choose_host(loaded, host)
    folder = state_dir or Registry().default_state_dir(running_name(loaded, host))
    stopping = _stop_on_signals()
    left_out = {ROUTER} if no_router else set()
    supervisor = Supervisor(
        deployment, loaded, folder, on_line=_print_line, host=host, leave_out=left_out
    )
    try:
        if ROUTER not in supervisor.processes and not router_reached(loaded, stopping, _print_line):
            return
        supervisor.start([name for name in order.split(",") if name] or None)
        wait_until_ready(supervisor, stopping)
        if not stopping.is_set():  # else asked to end while it started
            _watch(supervisor, stopping, folder)
    finally:
        killed = supervisor.stop()
        if killed:
            _print_line("up", f"had to kill: {', '.join(killed)}")
    _print_line("up", f"stopped {supervisor.name}; no process is left")


def _watch(supervisor: Supervisor, stopping: threading.Event, folder: Path) -> None:
    deployment = supervisor.deployment
    with RobotClient(deployment, by="fairlead up") as client:
        others = OtherHosts(client, supervisor.processes, _print_line)
        greeted = False
        while not stopping.wait(WATCH_S):
            for event in supervisor.poll():
                _say(event, client)
            if others.are_there() and not greeted:
                greeted = True
                _greet_or_say(client, folder)
        if client.gate in supervisor.processes:
            _disarm(client)


def wait_until_ready(supervisor: Supervisor, stopping: threading.Event) -> None:
    """Wait for every service's ``ready``, unless asked to stop meanwhile."""
    deadline = READY_TIMEOUT_S
    while not stopping.is_set():
        try:
            supervisor.wait_ready(1.0)
            return
        except ServiceError:
            deadline -= 1.0
            if supervisor.died() or deadline <= 0:
                raise


def _stop_on_signals() -> threading.Event:
    stopping = threading.Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        stopping.set()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, on_signal)
    return stopping


def _print_line(service: str, line: str) -> None:
    try:
        typer.echo(f"[{service}] {line}")
    except BrokenPipeError:  # whoever read our output has gone: end as on Ctrl-C
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        os.kill(os.getpid(), signal.SIGTERM)


def _greet_or_say(client: RobotClient, folder: Path) -> None:
    try:
        _greet(client, folder)
    except FairleadError as error:
        if client.deployment.router is None:
            raise
        _print_line("up", str(error))  # another host's to mend; what runs here goes on


def _greet(client: RobotClient, folder: Path) -> None:
    gate = client.wait_gate_follows()
    _print_line("up", f"{client.deployment.id} is up; state and logs: {folder}")
    if gate.state == GateState.DISARMED:
        _print_line("up", "in another terminal: fairlead run SKILL   (see: fairlead skill ls)")
    else:
        _explain_gate(client)


def _say(event: ServiceEvent, client: RobotClient) -> None:
    _print_line("up", event.text)
    if event.kind == "ready" and event.service == client.gate:
        try:
            _explain_gate(client)
        except FairleadError as error:
            _print_line("up", f"the gate does not answer yet: {error}")


def _explain_gate(client: RobotClient) -> None:
    """Say why the gate will not arm, and the commands that lead back to a goal."""
    gate = client.gate_status()
    _print_line("up", f"the gate is {state_and_cause(gate)}")
    for one in (gate.latch_id, *gate.stop_ids):
        if one:
            _print_line("up", f"when the cause is gone: fairlead reset {hex_id(one)}")


def _disarm(client: RobotClient) -> None:
    """End claims before the processes, so that the gate's end is a clean one."""
    try:
        if client.gate_status().state == GateState.ARMED:
            client.disarm()
    except FairleadError as error:
        _print_line("up", f"could not disarm before stopping: {error}")
