"""``fairlead service``: one service of a deployment, as this very process."""

from __future__ import annotations

import os
from typing import Annotated

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry, running_name
from fairlead.errors import ConfigError, ServiceError, expected
from fairlead_tools.cli.deployment_choice import DeploymentArgument, NewStateOption, StateDirOption
from fairlead_tools.supervisor.command_line import (
    new_state_command,
    service_command,
    service_environment,
)
from fairlead_tools.supervisor.ports import check_ports_free
from fairlead_tools.supervisor.this_host import choose_host

EXAMPLE = "fairlead service panda_mujoco hal"


def command(
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
    check_ports_free(loaded, [service])
    folder = (state_dir or Registry().default_state_dir(name)).absolute()
    build = new_state_command() if new_state else service_command
    words = build(deployment.absolute(), loaded, service, folder / service)
    (folder / service).mkdir(parents=True, exist_ok=True)
    own = process_id(os.getpid())
    entry = {service: ServiceEntry(own, ready=False, restarts=0, by_hand=True)}
    Registry().write_by_hand(
        service, Running(name, str(deployment.absolute()), str(folder), None, entry)
    )
    os.execve(words[0], words, service_environment())  # noqa: S606 - the command is ours


def _refuse_second(name: str, service: str) -> None:
    entry = Registry().find(name)
    running = entry.services[service].running if entry and service in entry.services else None
    if running is not None:
        raise ServiceError(
            f"{service} of {name} runs already (pid {running.pid}); end it first: "
            f"fairlead down {name}"
        )
