"""``fairlead arm``: let the gate grant claims."""

from __future__ import annotations

from fairlead.operate.client import RobotClient
from fairlead_tools.cli.arming import YesOption, arm_after_asking
from fairlead_tools.cli.console import echo, hex_id
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment

EXAMPLE = "fairlead arm"


def command(deployment: DeploymentOption = None, yes: YesOption = False) -> None:
    """Arm the gate: a new epoch starts, runners may claim parts of the robot.

    With profile `hardware` it asks first; where nobody can answer it refuses, but with --yes.
    """
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = arm_after_asking(client, client.gate_status(), yes)
    echo(f"armed {chosen.id}: epoch {hex_id(reply.epoch)}")
