"""``fairlead skill check``: may this skill run on this robot?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.admission import admission_problems
from fairlead.cli.console import print_json
from fairlead.cli.deployment_choice import JsonOption
from fairlead.client import RobotClient
from fairlead.deployment import load_deployment
from fairlead.messages import HalStatus
from fairlead.robot import load_robot
from fairlead.skill import load_skill

EXAMPLE = "fairlead skill check oracle-counter-to-cabinet --robot panda_mobile"


def command(
    skill: Annotated[str, typer.Argument(help="folder under rskills/")],
    robot: Annotated[str, typer.Option(help="folder under robots/")] = "panda_mobile",
    deployment: Annotated[
        Path | None,
        typer.Option(
            "--deployment",
            "-d",
            exists=True,
            dir_okay=False,
            help="also compare with the robot that runs here: ranges, part order, cameras",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Check a skill's manifest and whether the robot admits it; exit 1 with every reason if not."""
    problems = admission_problems(load_skill(skill), load_robot(robot), _running(deployment))
    if as_json:
        print_json({"skill": skill, "robot": robot, "admitted": not problems, "reasons": problems})
    elif problems:
        typer.echo(f"{skill} cannot run on {robot}:\n  " + "\n  ".join(problems))
        typer.echo(f"fix rskills/{skill}/rskill.yaml, then: fairlead skill check {skill}")
    else:
        typer.echo(f"{skill} may run on {robot}")
    if problems:
        raise typer.Exit(1)


def _running(deployment: Path | None) -> HalStatus | None:
    if deployment is None:
        return None
    with RobotClient(load_deployment(deployment)) as client:
        return client.hal_status()
