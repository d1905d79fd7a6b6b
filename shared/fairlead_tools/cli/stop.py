"""``fairlead stop``: request a protective stop."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import running_name
from fairlead.errors import FairleadError
from fairlead.operate.client import RobotClient
from fairlead.operate.which_deployment import running_files
from fairlead_tools.cli.console import echo, hex_id
from fairlead_tools.cli.deployment_choice import DeploymentOption

EXAMPLE = 'fairlead stop --reason "hand in the cell"'


def command(
    deployment: DeploymentOption = None,
    reason: Annotated[str, typer.Option(help="why, for the log")] = "operator",
) -> None:
    """Request a protective stop: a controlled standstill until its id is reset.

    Without --deployment of every robot that runs on this machine. This is not an emergency
    stop: use the robot's own for that.
    """
    files = [deployment] if deployment is not None else running_files()
    with ThreadPoolExecutor(len(files)) as at_once:  # nobody's stop waits for another's
        outcomes = list(at_once.map(lambda file: _stop(file, reason), files))
    failed = False
    for file, outcome in zip(files, outcomes, strict=True):
        if isinstance(outcome, FairleadError):
            failed = True
            echo(f"ERROR {file}: NOT STOPPED: {outcome}", err=True)
            continue
        robot, stop_id = outcome
        which = f" --deployment {file}" if len(files) > 1 else ""
        echo(f"stopped {robot}; when it is safe: fairlead reset {hex_id(stop_id)}{which}")
    if failed:
        raise typer.Exit(1)


def _stop(file: Path, reason: str) -> tuple[str, int] | FairleadError:
    try:
        chosen = load_deployment(file)
        with RobotClient(chosen) as client:
            return running_name(chosen), client.stop(reason)
    except FairleadError as error:
        return error
