"""``fairlead disarm``: end every claim."""

from __future__ import annotations

from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment

EXAMPLE = "fairlead disarm"


def command(deployment: DeploymentOption = None) -> None:
    """Disarm the gate: every claim ends, the robot holds; goals that ran fail visibly."""
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = client.disarm()
    echo(reply.text or f"disarmed {chosen.id}")
