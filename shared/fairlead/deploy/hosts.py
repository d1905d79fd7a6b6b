"""More than one host: their addresses, the router that joins them, who and what is on them."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Collection, Mapping, Sequence

from pydantic import BaseModel, ConfigDict, Field

from fairlead.deploy.service_spec import ServiceSpec
from fairlead.errors import expected

ROUTER = "router"
"""The router's name beside the services, in logs and in lists of processes."""

_NAME = re.compile(r"[a-z0-9][a-z0-9_\-]*")
_LABEL = r"[A-Za-z0-9](?:[A-Za-z0-9\-]{0,61}[A-Za-z0-9])?"
_HOST_NAME = re.compile(rf"(?=.{{1,253}}$)(?:{_LABEL}\.)*(?![0-9]+\Z){_LABEL}")  # no 192.168.1.300


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
        if not _is_one_hosts(address):
            problems.append(
                f"hosts.{name}: expected the one address or name by which the other hosts reach "
                f"it, such as 192.168.1.10, got {address!r}"
            )
        other = owners.setdefault(address, name)
        if other != name:
            problems.append(f"hosts: {other} and {name} have the same address {address}")
    return problems


def service_problems(
    services: Mapping[str, ServiceSpec], hosts: Collection[str], closed: bool
) -> list[str]:
    """What does not fit in where services are: on one of the hosts, or all on one without any.

    Args:
        closed: they listen where others cannot come.
    """
    problems, owners = [], dict[str, str]()
    for name, spec in services.items():
        other = owners.setdefault(spec.listen or name, name)
        if other != name:
            problems.append(f"services.{name}.listen: {other} listens on {spec.listen} too")
        if hosts and spec.host not in hosts:
            got = repr(spec.host) if spec.host else "none"
            problems.append(expected(f"services.{name}.host", "a host", got, hosts))
        if hosts and spec.listen:
            problems.append(
                f"services.{name}.listen: clients of a router listen nowhere; leave it out"
            )
        if not hosts and spec.listen and closed:
            problems.append(
                f"services.{name}.listen: leave it out: on one host services listen where this "
                "user alone can come (between hosts: give hosts and a router; a port, for whoever "
                "reaches it: access: open)"
            )
        if not hosts and spec.host:
            problems.append(f"services.{name}.host: {spec.host!r}, but there are no hosts")
    return problems


def people_problems(
    people: Sequence[str], router: RouterSpec | None, taken: Collection[str]
) -> list[str]:
    """What does not fit in a list of persons.

    Args:
        taken: names that a certificate, or its folder, has already.
    """
    if people and router is None:
        return ["people: certificates prove them, which are for hosts and a router"]
    problems = []
    for place, name in enumerate(people):
        if not _NAME.fullmatch(name):
            problems.append(f"people: {name!r}: expected a name of a-z 0-9 _ -")
        if name in taken or name in people[:place]:
            problems.append(f"people: {name}: another has this name; each person needs an own one")
    return problems


def place_of(name: str, services: Collection[str], people: Collection[str], localiser: str) -> str:
    """Where a deployment file has a name; the robot's where it has none of its own."""
    if name in people:
        return f"people: {name}"
    return "localiser" if name == localiser else f"services.{name}" if name in services else "id"


def long_names(names: Mapping[str, str], most: int) -> list[str]:
    """Which names, by place, no certificate can have."""
    return [
        f"{place}: {name} is longer than the {most} signs that a certificate can name"
        for place, name in names.items()
        if len(name) > most
    ]


def endpoint_of(protocol: str, address: str, port: int) -> str:
    """A Zenoh endpoint; IPv6 addresses get their brackets."""
    return f"{protocol}/[{address}]:{port}" if ":" in address else f"{protocol}/{address}:{port}"


def _is_one_hosts(address: str) -> bool:
    """Whether an address or a name can be that of one host, and means the same to everybody."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return _HOST_NAME.fullmatch(address) is not None
    return not (found.is_unspecified or found.is_multicast or "%" in address)


def port_of(endpoint: str) -> int:
    """Port of an endpoint that has one."""
    return int(endpoint.rpartition(":")[2])
