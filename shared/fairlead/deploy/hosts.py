"""More than one host: the hosts' addresses, and the router that joins them."""

from __future__ import annotations

import ipaddress
import re

from pydantic import BaseModel, ConfigDict, Field

from fairlead.errors import expected

ROUTER = "router"
"""The router's name beside the services, in logs and in lists of processes."""

_NAME = re.compile(r"[a-z0-9][a-z0-9_\-]*")
_ADDRESS = re.compile(r"[A-Za-z0-9][A-Za-z0-9.:\-]*")


class RouterSpec(BaseModel):
    """Where the router runs: on one of the hosts, reached at that host's address."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    host: str
    port: int = Field(ge=1, le=65535)


def host_problems(hosts: dict[str, str], router: RouterSpec, certified: bool) -> list[str]:
    """What does not fit in a table of hosts and addresses, and in where the router is.

    Args:
        certified: its clients know the router by the address in its certificate.
    """
    problems = []
    if router.host not in hosts:
        problems.append(expected("router.host", "a host", repr(router.host), hosts))
    elif certified and ":" in hosts[router.host]:
        problems.append(
            f"hosts.{router.host}: expected a name or an IPv4 address, got {hosts[router.host]}: "
            "Zenoh cannot hold a certificate against an IPv6 address"
        )
    owners: dict[str, str] = {}
    for name, address in hosts.items():
        if not _NAME.fullmatch(name):
            problems.append(f"hosts: {name!r}: expected a name of a-z 0-9 _ -")
        if not _ADDRESS.fullmatch(address) or _is_everywhere(address):
            problems.append(
                f"hosts.{name}: expected the one address or name by which the other hosts reach "
                f"it, such as 192.168.1.10, got {address!r}"
            )
        other = owners.setdefault(address, name)
        if other != name:
            problems.append(f"hosts: {other} and {name} have the same address {address}")
    return problems


def endpoint_of(protocol: str, address: str, port: int) -> str:
    """A Zenoh endpoint; IPv6 addresses get their brackets."""
    return f"{protocol}/[{address}]:{port}" if ":" in address else f"{protocol}/{address}:{port}"


def _is_everywhere(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_unspecified
    except ValueError:  # a name
        return False
