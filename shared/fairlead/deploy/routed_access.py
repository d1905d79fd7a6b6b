"""What a router and its clients let through: the same table, names proved by certificates.

Behind a router a session sees the router alone; who sent a message only the router knows. So the
router keeps to the table for each name in both directions, and each client once more to what its
own name may send and get from anybody. A name has its robot's in front (`common_name`): a router of
several robots gives each of them its own keys.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from fairlead.deploy.access import Grant, Parties, access_control, grants, rules
from fairlead.deploy.certificates import common_name, find_certificate, transport
from fairlead.deploy.hosts import ROUTER
from fairlead.keys import Keys

Subject = tuple[dict[str, Any], list[dict[str, Any]]]


def router_access(robots: Iterable[Parties]) -> dict[str, Any]:
    """The part of a Zenoh configuration that has a router give each name what is its own."""
    subjects = [one for parties in robots for one in _subjects(parties)]
    return {"access_control": access_control(subjects)}


def _subjects(parties: Parties) -> Iterable[Subject]:
    every = list(grants(parties, namesakes=True))
    for name in parties.names:
        both = [*rules(_sent(every, name), "ingress"), *rules(_got(every, name), "egress")]
        yield _known_as(parties.keys, name), both


def client_access(parties: Parties, own: str, hosts: Sequence[str]) -> dict[str, Any]:
    """The part of a Zenoh configuration that makes a session this party's, on one of the hosts.

    It knows its router by name too: Zenoh also believes whom public authorities have signed.

    Raises:
        ConfigError: it has no certificate that can be used.
    """
    mine = find_certificate(parties.keys, hosts, own)
    every = list(grants(parties, namesakes=True))
    both = [*rules(_sent(every, own), "egress"), *rules(_got(every, own), "ingress")]
    control = access_control([(_known_as(parties.keys, ROUTER), both)])
    return {"transport": transport(mine), "access_control": control}


def _known_as(keys: Keys, name: str) -> dict[str, Any]:
    known = common_name(keys, name)
    return {"id": known, "cert_common_names": [known]}


def _sent(every: Iterable[Grant], name: str) -> Iterable[Grant]:
    return (one for one in every if one.sender == name)


def _got(every: Iterable[Grant], name: str) -> Iterable[Grant]:
    """What one sender may not send another may, so its exceptions are kept where it sends."""
    return (replace(one, but=()) for one in every if one.receiver == name)
