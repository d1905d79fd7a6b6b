"""``fairlead stop``: request a protective stop."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.cli.console import hex_id
from fairlead.cli.deployment_choice import DeploymentOption, choose_deployment
from fairlead.operate.client import RobotClient

EXAMPLE = 'fairlead stop --reason "hand in the cell"'


def command(
    deployment: DeploymentOption = None,
    reason: Annotated[str, typer.Option(help="why, for the log")] = "operator",
) -> None:
    """Request a protective stop: a controlled standstill until its id is reset.

    This is not an emergency stop: use the robot's own for that.
    """
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        stop_id = client.stop(reason)
    typer.echo(f"stopped {chosen.id}; when it is safe: fairlead reset {hex_id(stop_id)}")
