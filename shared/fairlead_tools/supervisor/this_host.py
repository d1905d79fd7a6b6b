"""What this machine is to a deployment: which of its hosts, and where it can listen."""

from __future__ import annotations

import socket
from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER, port_of
from fairlead.deploy.process_table import Place, command_of, is_listening, listener_of
from fairlead.deploy.registry import Registry
from fairlead.deploy.sockets import socket_path
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


def check_places_free(deployment: Deployment, names: Iterable[str]) -> None:
    """Make sure that nobody listens where these processes of a deployment will.

    Raises:
        ServiceError: naming the service, the port or socket, and the process that has it.
        ConfigError: its socket cannot be made.
    """
    for name in names:
        is_router = name == ROUTER and deployment.router is not None
        endpoint = deployment.router_endpoint if is_router else deployment.listen(name)
        socket_of = socket_path(endpoint)
        place = socket_of or (port_of(endpoint) if endpoint else 0)
        if is_listening(place):
            raise ServiceError(
                f"{name}: its {'socket' if socket_of else 'port'} {place} is taken by "
                f"{_owner(place)}; stop that first ({_how_to_stop(place)})"
                + ("" if socket_of else f" or give {name} another port")
            )


def free_ports(count: int) -> list[int]:
    """Different loopback ports that were free a moment ago."""
    with ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [int(one.getsockname()[1]) for one in sockets]


def _how_to_stop(place: Place) -> str:
    """The command that ends whoever listens: another deployment, or any process."""
    pid = listener_of(place)
    for entry in Registry().entries():
        if pid is not None and pid in [process.pid for process in entry.leftovers]:
            return f"fairlead down {entry.name}"
    return f"kill {pid}" if pid is not None else "ask its owner"


def _owner(place: Place) -> str:
    pid = listener_of(place)
    if pid is None:
        return "a process of another user"
    return f"pid {pid} ({' '.join(command_of(pid).split())[:120]})"
