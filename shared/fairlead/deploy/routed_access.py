"""What a router and its clients let through: the same table, names proved by certificates.

Behind a router a session sees the router alone; who sent a message only the router knows. So the
router keeps to the table for each name in both directions, and each client once more to what its
own name may send and get from anybody.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from fairlead.deploy.access import Grant, Parties, access_control, grants, rules
from fairlead.deploy.certificates import check_address, find_certificate, transport
from fairlead.deploy.hosts import ROUTER


def router_access(parties: Parties, host: str, address: str) -> dict[str, Any]:
    """The part of a Zenoh configuration that makes a session the router, which knows names.

    Raises:
        ConfigError: it has no certificate that can be used at this address.
    """
    mine = find_certificate(parties.keys, [host], ROUTER)
    check_address(mine, address)
    every = list(grants(parties, namesakes=True))
    subjects = [
        (
            _known_as(name),
            [*rules(_sent(every, name), "ingress"), *rules(_got(every, name), "egress")],
        )
        for name in parties.names
    ]
    return {"transport": transport(mine, "listen"), "access_control": access_control(subjects)}


def client_access(parties: Parties, own: str, hosts: Sequence[str]) -> dict[str, Any]:
    """The part of a Zenoh configuration that makes a session this party's, on one of the hosts.

    It knows its router by name too: Zenoh also believes whom public authorities have signed.

    Raises:
        ConfigError: it has no certificate that can be used.
    """
    mine = find_certificate(parties.keys, hosts, own)
    every = list(grants(parties, namesakes=True))
    both = [*rules(_sent(every, own), "egress"), *rules(_got(every, own), "ingress")]
    control = access_control([(_known_as(ROUTER), both)])
    return {"transport": transport(mine, "connect"), "access_control": control}


def _known_as(name: str) -> dict[str, Any]:
    return {"id": name, "cert_common_names": [name]}


def _sent(every: Iterable[Grant], name: str) -> Iterable[Grant]:
    return (one for one in every if one.sender == name)


def _got(every: Iterable[Grant], name: str) -> Iterable[Grant]:
    """What one sender may not send another may, so its exceptions are kept where it sends."""
    return (replace(one, but=()) for one in every if one.receiver == name)
