"""Loopback ports: which are free, and who holds the one a service needs."""

from __future__ import annotations

import socket
from collections.abc import Iterable
from contextlib import ExitStack

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.process_table import command_of, is_listening, listener_of
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, ServiceError


def port_of(endpoint: str) -> int:
    """The port of an endpoint such as ``tcp/127.0.0.1:7501``.

    Raises:
        ConfigError: if there is none.
    """
    port = endpoint.rpartition(":")[2]
    if not port.isdigit():
        raise ConfigError(f"endpoint: expected one like tcp/127.0.0.1:7501, got {endpoint}")
    return int(port)


def check_ports_free(deployment: Deployment, names: Iterable[str]) -> None:
    """Make sure that nobody listens where these processes of a deployment will.

    Raises:
        ServiceError: naming the service, the port and the process that has it.
    """
    for name in names:
        endpoint = _endpoint(deployment, name)
        if endpoint and is_listening(port_of(endpoint)):
            port = port_of(endpoint)
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
