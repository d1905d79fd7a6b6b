"""``fairlead ps``: what was started on this machine, and who else is there."""

from __future__ import annotations

from pathlib import Path

import msgspec

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry, Running, ServiceEntry, running_name
from fairlead.errors import ConfigError, TransportError
from fairlead.operate.client import alive_services
from fairlead.operate.which_deployment import nothing_runs
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import DeploymentOption, JsonOption

EXAMPLE = "fairlead ps"


def command(deployment: DeploymentOption = None, as_json: JsonOption = False) -> None:
    """List the deployments started on this machine and their processes.

    Also services that are seen on the network but were started elsewhere: of these
    deployments, or of the one named.
    """
    entries = _entries(deployment)
    seen = {entry.name: _alive(entry) for entry in entries if not _is_whole(entry)}
    if as_json:
        print_json([_document(entry, seen.get(entry.name, frozenset())) for entry in entries])
        return
    rows = [row for entry in entries for row in _rows(entry, seen.get(entry.name, frozenset()))]
    if not rows:
        echo(str(nothing_runs()))
        return
    print_table(("DEPLOYMENT", "SERVICE", "PID", "STATE", "RESTARTS"), rows)
    for entry in entries:
        if entry.supervisor is not None and not entry.is_supervised:
            echo(f"{entry.name}: its supervisor is gone; clean up: fairlead down {entry.name}")


def _entries(file: Path | None) -> list[Running]:
    """What was started here; with a file: of that deployment, an empty entry if nothing was."""
    entries = Registry().entries()
    if file is None:
        return entries
    same = [entry for entry in entries if Path(entry.deployment).resolve() == file.resolve()]
    return same or [Running(running_name(load_deployment(file)), str(file), "", None)]


def _is_whole(entry: Running) -> bool:
    """Whether a supervisor knows all there is to know: nothing to ask the network."""
    return (
        entry.is_supervised
        and not entry.by_hand
        and set(_file_services(entry)) <= set(entry.services)
    )


def _file_services(entry: Running) -> list[str]:
    try:
        return list(load_deployment(Path(entry.deployment)).services)
    except ConfigError:  # edited or deleted since
        return []


def _alive(entry: Running) -> frozenset[str]:
    try:
        return alive_services(load_deployment(Path(entry.deployment)))
    except (ConfigError, TransportError):  # edited since, or its router is away
        return frozenset()


def _rows(entry: Running, alive: frozenset[str]) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = [
        (entry.name, name, _pid(service), _state(entry, name, service, alive), service.restarts)
        for name, service in entry.services.items()
    ]
    return rows + [
        (entry.name, name, "-", "elsewhere", "-") for name in sorted(alive - set(entry.services))
    ]


def _document(entry: Running, alive: frozenset[str]) -> object:
    document = msgspec.to_builtins(entry)
    document["supervised"] = entry.is_supervised
    document["elsewhere"] = sorted(alive - set(entry.services))
    for name, service in entry.services.items():
        document["services"][name]["state"] = _state(entry, name, service, alive)
    return document


def _pid(service: ServiceEntry) -> str:
    return str(service.process.pid) if service.process is not None else "-"


def _state(entry: Running, name: str, service: ServiceEntry, alive: frozenset[str]) -> str:
    if service.by_hand:
        return "ready, by hand" if name in alive else "starting, by hand"
    if service.process is None:
        return "waiting" if entry.is_supervised else "dead"
    if service.running is None:
        return "restarting" if entry.is_supervised else "dead"
    if not entry.is_supervised:
        return "left over"
    return "ready" if service.ready else "starting"
