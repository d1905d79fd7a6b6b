"""``fairlead reset ID``: acknowledge one stop or latch."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment

EXAMPLE = "fairlead reset 5f0c3a9e12d4b687"
_HIGHEST_ID = 2**64 - 1


def parse_id(text: str) -> int:
    """A stop's or latch's id, written in hex as `fairlead status` prints it."""
    try:
        number = int(text, 16)
    except ValueError:
        number = 0
    if not 0 < number <= _HIGHEST_ID:
        raise typer.BadParameter(
            f"expected 1 to 16 hex digits as printed by `fairlead status`, got {text!r}"
        )
    return number


def command(
    acknowledged: Annotated[
        int, typer.Argument(parser=parse_id, metavar="ID", help="the stop or latch id")
    ],
    deployment: DeploymentOption = None,
) -> None:
    """Acknowledge one stop or latch by its id; leads to disarmed, never to motion."""
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = client.reset(acknowledged)
        left = client.gate_status()
    echo(reply.text or f"reset {chosen.id}")
    echo(f"next: {left.fix or 'fairlead arm'}")
