"""What this machine is to a deployment: which of its hosts, and which ports are free."""

from __future__ import annotations

import socket
from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER, place_at
from fairlead.deploy.process_table import command_of, is_listening, listener_of
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, ServiceError, expected


def choose_host(deployment: Deployment, wanted: str | None) -> str | None:
    """The host whose services are started here; None where there are no hosts.

    Raises:
        ConfigError: none was named of several, or one that the file does not have.
        ServiceError: its address is not this machine's.
    """
    hosts = deployment.hosts
    if not hosts:
        if wanted is not None:
            raise ConfigError(
                f"deployment {deployment.id}: --host {wanted}: the file has no hosts; all its "
                "services run on this machine, without --host"
            )
        return None
    if wanted is None and len(hosts) > 1:
        raise ConfigError(
            f"deployment {deployment.id} has {len(hosts)} hosts; start each on its own machine, "
            f"with --host (valid: {_listed(hosts)}){_hint(hosts)}"
        )
    host = wanted if wanted is not None else next(iter(hosts))
    if host not in hosts:
        raise ConfigError(expected("--host", "a host of the file", repr(host), hosts))
    if not is_own_address(host, hosts[host]):
        raise ServiceError(
            f"host {host}: its address {hosts[host]} is none of this machine's (see: ip addr); "
            f"correct hosts.{host} in the deployment file, on every host{_hint(hosts)}"
        )
    return host


def is_own_address(host: str, address: str) -> bool:
    """Whether a process on this machine can listen on an address or name.

    Raises:
        ServiceError: if the name is not known here.
    """
    try:
        found = socket.getaddrinfo(address, 0, type=socket.SOCK_STREAM)
    except OSError as error:
        raise ServiceError(
            f"host {host}: its name {address} is not known here ({error}); write its address"
        ) from None
    return any(_can_bind(family, where) for family, _, _, _, where in found)


def _can_bind(family: int, where: tuple[Any, ...]) -> bool:
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        try:
            probe.bind(where)
        except OSError:
            return False
    return True


def _listed(hosts: dict[str, str]) -> str:
    return ", ".join(f"{name} at {address}" for name, address in hosts.items())


def _hint(hosts: dict[str, str]) -> str:
    """Which hosts this machine could be, for people at the wrong one."""
    here = []
    for name, address in hosts.items():
        try:
            if is_own_address(name, address):
                here.append(name)
        except ServiceError:
            continue
    return f"; this machine has the address of {', '.join(here)}" if here else ""


def check_ports_free(deployment: Deployment, names: Iterable[str]) -> None:
    """Make sure that nobody listens where these processes of a deployment will.

    Raises:
        ServiceError: naming the service, the port and the process that has it.
    """
    for name in names:
        endpoint = _endpoint(deployment, name)
        port = place_at(endpoint)[1] if endpoint else 0
        if is_listening(port):
            raise ServiceError(
                f"{name}: its port {port} is taken by {_owner(port)}; stop that first "
                f"({_how_to_stop(port)}) or give {name} another port"
            )


def _endpoint(deployment: Deployment, name: str) -> str:
    """Where a process listens; "" for a client of the router."""
    if name == ROUTER and deployment.router is not None:
        return deployment.router_endpoint
    return deployment.services[name].listen


def free_ports(count: int) -> list[int]:
    """Different loopback ports that were free a moment ago."""
    with ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [int(one.getsockname()[1]) for one in sockets]


def _how_to_stop(port: int) -> str:
    """The command that ends whoever listens: another deployment, or any process."""
    pid = listener_of(port)
    for entry in Registry().entries():
        if pid is not None and pid in [process.pid for process in entry.leftovers]:
            return f"fairlead down {entry.name}"
    return f"kill {pid}" if pid is not None else "ask its owner"


def _owner(port: int) -> str:
    pid = listener_of(port)
    if pid is None:
        return "a process of another user"
    return f"pid {pid} ({' '.join(command_of(pid).split())[:120]})"
