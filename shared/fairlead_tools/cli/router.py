"""``fairlead router``: what joins the services of a deployment with several hosts."""

from __future__ import annotations

import logging
import sys
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.stop_signals import StopSignals
from fairlead.errors import ConfigError
from fairlead.wire.printable import LineFormatter
from fairlead.wire.session import Endpoints, ZenohBus
from fairlead_tools.cli.console import print_json
from fairlead_tools.cli.deployment_choice import DeploymentArgument
from fairlead_tools.supervisor.ports import check_ports_free
from fairlead_tools.supervisor.this_host import choose_host

EXAMPLE = "fairlead router panda_mobile_two_hosts --json"


def command(
    deployment: DeploymentArgument,
    as_json: Annotated[
        bool,
        typer.Option(
            "--json",
            "--print-config",
            help="print the Zenoh configuration instead, as zenohd reads it",
        ),
    ] = False,
) -> None:
    """Run a deployment's router in the foreground, on its host; `up` there starts it too."""
    loaded = load_deployment(deployment)
    endpoints = router_endpoints(loaded)
    if as_json:
        print_json(endpoints.config())
        return
    assert loaded.router is not None
    choose_host(loaded, loaded.router.host)
    check_ports_free(loaded, [ROUTER])
    _serve(endpoints)


def router_endpoints(deployment: Deployment) -> Endpoints:
    """The router's own endpoints.

    Raises:
        ConfigError: if the deployment has no router.
    """
    if deployment.router is None:
        raise ConfigError(
            f"deployment {deployment.id}: has no router: its services are peers on one host; "
            "see docs/hosts.md"
        )
    return Endpoints(listen=[deployment.router_endpoint], mode="router")


def _serve(endpoints: Endpoints) -> None:
    """Route until asked to stop; all of it happens in Zenoh's own threads."""
    handler = logging.StreamHandler(sys.stdout)
    handler.setFormatter(LineFormatter())
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    signals, log = StopSignals("router"), logging.getLogger(ROUTER)
    bus = ZenohBus(endpoints)
    signals.started()
    log.info("listens on %s", ", ".join(endpoints.listen))
    log.info("ready")
    signals.stopping.wait()
    bus.close()
