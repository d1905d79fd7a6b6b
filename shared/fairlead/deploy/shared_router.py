"""One router for one robot or several: each with a port, certificates and rules of its own."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from fairlead.deploy.certificates import certified_endpoint, check_address, find_certificate
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.routed_access import router_access
from fairlead.errors import ConfigError
from fairlead.wire.endpoints import Endpoints


def router_endpoints(deployments: Sequence[Deployment]) -> Endpoints:
    """Where a router listens for these robots, and what it lets through.

    Raises:
        ConfigError: as `check_shared`, or one has no certificate for its address.
    """
    check_shared(deployments)
    listen = [_endpoint(one) for one in deployments]
    closed = [one for one in deployments if not one.open_access]
    access = router_access(one.parties for one in closed) if closed else {}
    return Endpoints(listen=listen, mode="router", access=access)


def check_shared(deployments: Sequence[Deployment]) -> None:
    """Whether one router can serve these robots.

    Raises:
        ConfigError: one has no router; two have the same id or port; the access of some is open,
            and of others closed.
    """
    for one, other in combinations(deployments, 2):
        for what, same in (
            ("id", one.keys == other.keys),
            ("router.port", one.routed.port == other.routed.port),
        ):
            if same:
                raise ConfigError(
                    f"{ROUTER}: {one.id} and {other.id} have the same {what}; each robot needs "
                    "its own"
                )
    closed = [one for one in deployments if not one.open_access]
    if closed and len(closed) < len(deployments):
        opened = next(one.id for one in deployments if one.open_access)
        raise ConfigError(
            f"{ROUTER}: access of {opened} is open and of {closed[0].id} closed; a router keeps to "
            "rules for all of its robots or for none"
        )


def _endpoint(deployment: Deployment) -> str:
    host, endpoint = deployment.routed.host, deployment.router_endpoint
    if deployment.open_access:
        return endpoint
    certificate = find_certificate(deployment.keys, [host], ROUTER)
    check_address(certificate, deployment.hosts[host])
    return certified_endpoint(endpoint, certificate)
