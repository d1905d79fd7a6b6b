"""``fairlead cancel``: end the goal of one runner."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, expected
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment

EXAMPLE = "fairlead cancel runner"


def command(
    runner: Annotated[
        str | None, typer.Argument(help="a runner of the deployment; may be left out if only one")
    ] = None,
    deployment: DeploymentOption = None,
) -> None:
    """End the goal that a runner runs; its parts hold, other runners go on."""
    chosen = choose_deployment(deployment)
    name = _chosen_runner(chosen, runner)
    with RobotClient(chosen, by="fairlead cancel") as client:
        reply = client.cancel(name, client.goal_feedback(name).goal_id)
    echo(f"{name}: {reply.text}")


def _chosen_runner(deployment: Deployment, named: str | None) -> str:
    runners = deployment.runners
    name = named or (runners[0] if len(runners) == 1 else None)
    if name in runners:
        return name
    if named is None:
        raise ConfigError(expected("cancel", "the name of a runner", "none", runners))
    what = expected(f"deployment {deployment.id}", "a runner", repr(named), runners)
    raise ConfigError(
        f"{what}; a claim of another program ends where it was started; fairlead disarm ends all"
    )
