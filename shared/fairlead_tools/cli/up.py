"""``fairlead up``: start one host's services and keep them running."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.registry import Registry, running_name
from fairlead.errors import ConfigError, FairleadError, expected
from fairlead.messages import GateState
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.background import UpOutput, start_in_background
from fairlead_tools.cli.deployment_choice import DeploymentArgument, NewStateOption, StateDirOption
from fairlead_tools.cli.dropped_skills import dropped_skills
from fairlead_tools.cli.greeting import Greeting, Say, explain_gate
from fairlead_tools.cli.other_hosts import OtherHosts, router_reached
from fairlead_tools.supervisor import ServiceEvent, Supervisor
from fairlead_tools.supervisor.command_line import (
    check_gate_file,
    new_state_command,
    service_command,
)
from fairlead_tools.supervisor.this_host import choose_host

EXAMPLE = "fairlead up panda_mobile_sim"
READY_TIMEOUT_S = 120.0  # a first start compiles and caches much on a slow machine
WATCH_S = 0.1
IN_BACKGROUND = "--in-background"


def command(
    deployment: DeploymentArgument,
    state_dir: StateDirOption = None,
    order: Annotated[str, typer.Option(help="start order, comma-separated; any order works")] = "",
    host: Annotated[
        str | None, typer.Option(help="which host of the file this machine is, if it has several")
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(
            help="a service (or router) that somebody else runs: fairlead service; repeatable"
        ),
    ] = None,
    new_state: NewStateOption = False,
    detach: Annotated[
        bool, typer.Option("--detach", help="return once all is ready; it runs on until `down`")
    ] = False,
    in_background: Annotated[
        bool, typer.Option(IN_BACKGROUND, hidden=True, help="what --detach starts")
    ] = False,
) -> None:
    """Start a deployment's services (on one host), print their logs, restart what dies.

    It runs until Ctrl-C, or with --detach until `fairlead down`. A deployment of several hosts is
    started once on each, with --host, in any order.
    """
    loaded = load_deployment(deployment)
    _ = loaded.hal, loaded.only("safety")  # refused before a start
    host = choose_host(loaded, host)
    name = running_name(loaded, host)
    if detach:
        words = [IN_BACKGROUND if word == "--detach" else word for word in sys.argv[1:]]
        start_in_background(words, name)
        return
    folder = state_dir or Registry().default_state_dir(name)
    stopping = _stop_on_signals()
    say = UpOutput(folder)
    supervisor = Supervisor(
        deployment,
        loaded,
        folder,
        on_line=say,
        command=new_state_command() if new_state else service_command,
        host=host,
        leave_out=_left_out(loaded, without or []),
    )
    if loaded.only("safety") in supervisor.processes:
        check_gate_file(loaded)
    for runner in loaded.runners:
        if runner in supervisor.processes:
            for line in dropped_skills(loaded, runner):
                say("up", line)
    try:
        supervisor.reserve()
        if ROUTER not in supervisor.processes and not router_reached(loaded, stopping, say):
            return
        supervisor.start([name for name in order.split(",") if name] or None)
        supervisor.wait_ready(READY_TIMEOUT_S, stopping, lambda event: say("up", event.text))
        if not stopping.is_set():  # else asked to end while it started
            _watch(supervisor, stopping, say, detach=in_background)
    finally:
        killed = supervisor.stop()
        if killed:
            say("up", f"had to kill: {', '.join(killed)}")
    say("up", f"stopped {supervisor.name}; no process is left")


def _left_out(deployment: Deployment, names: list[str]) -> list[str]:
    known = [*deployment.services, *([ROUTER] if deployment.router else [])]
    for name in names:
        if name not in known:
            raise ConfigError(expected("--without", "a service of the file", repr(name), known))
    return names


def _watch(supervisor: Supervisor, stopping: threading.Event, say: UpOutput, detach: bool) -> None:
    with RobotClient(supervisor.deployment, by="fairlead up") as client:
        others = OtherHosts(client, supervisor.processes, say)
        greeting = Greeting(client, supervisor.state_dir, say)
        while not stopping.wait(WATCH_S):
            for event in supervisor.poll():
                _tell(event, client, say)
            if others.are_there() and greeting.say_once_up() and detach:
                say.detach()
        if client.gate in supervisor.processes:
            _disarm(client, say)


def _stop_on_signals() -> threading.Event:
    stopping = threading.Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        stopping.set()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, on_signal)
    return stopping


def _tell(event: ServiceEvent, client: RobotClient, say: Say) -> None:
    say("up", event.text)
    if event.kind == "ready" and event.service == client.gate:
        try:
            explain_gate(client.gate_status(), say)
        except FairleadError as error:
            say("up", f"the gate does not answer yet: {error}")


def _disarm(client: RobotClient, say: Say) -> None:
    """End claims before the processes, so that the gate's end is a clean one."""
    try:
        if client.gate_status().state == GateState.ARMED:
            client.disarm()
    except FairleadError as error:
        say("up", f"could not disarm before stopping: {error}")
