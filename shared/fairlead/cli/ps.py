"""``fairlead ps``: what was started on this machine."""

from __future__ import annotations

import msgspec
import typer

from fairlead.cli.console import print_json, print_table
from fairlead.cli.deployment_choice import JsonOption, nothing_runs
from fairlead.supervisor import Registry, Running
from fairlead.supervisor.registry import ServiceEntry

EXAMPLE = "fairlead ps"


def command(as_json: JsonOption = False) -> None:
    """List the deployments started on this machine and their processes."""
    entries = Registry().entries()
    if as_json:
        print_json([_document(entry) for entry in entries])
        return
    if not entries:
        typer.echo(str(nothing_runs()))
        return
    rows = [
        (entry.name, name, _pid(service), _state(entry, service), service.restarts)
        for entry in entries
        for name, service in entry.services.items()
    ]
    print_table(("DEPLOYMENT", "SERVICE", "PID", "STATE", "RESTARTS"), rows)
    for entry in entries:
        if not entry.is_supervised:
            typer.echo(
                f"{entry.name}: its supervisor is gone; clean up: fairlead down {entry.name}"
            )


def _document(entry: Running) -> object:
    document = msgspec.to_builtins(entry)
    document["supervised"] = entry.is_supervised
    for name, service in entry.services.items():
        document["services"][name]["state"] = _state(entry, service)
    return document


def _pid(service: ServiceEntry) -> str:
    return str(service.process.pid) if service.process is not None else "-"


def _state(entry: Running, service: ServiceEntry) -> str:
    if service.process is None or not service.process.is_running:
        return "restarting" if entry.is_supervised else "dead"
    if not entry.is_supervised:
        return "left over"
    return "ready" if service.ready else "starting"
