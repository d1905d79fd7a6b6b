"""``fairlead robot new``: a robot's folder and deployment file, drafted from MJCF and URDF."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.keys import check_name
from fairlead.robot.home_check import singular_homes
from fairlead_tools.cli.by_hand import ends_like_ctrl_c
from fairlead_tools.cli.console import ProgressLine, echo
from fairlead_tools.cli.options import example


@example("fairlead robot new my_arm --mjcf my_arm.xml")
def new_command(
    name: Annotated[str, typer.Argument(metavar="ID", help="the robot's id, and its folder")],
    mjcf: Annotated[
        Path | None, typer.Option(help="its MuJoCo model, for geometry and servos")
    ] = None,
    urdf: Annotated[
        Path | None,
        typer.Option(help="its description, with speeds and efforts; else made of the MJCF"),
    ] = None,
) -> None:
    """Draft a robot from its files: limits, capsules, home, URDF, and a deployment file here.

    The folder goes to $FAIRLEAD_ROBOTS, else ~/.local/share/fairlead/robots. What no file says is
    assumed and listed in robot.yaml, to_confirm: the profile hardware is refused until a person
    has gone through it.
    """
    from fairlead_tools.draft.deployment_text import deployment_text
    from fairlead_tools.draft.new_robot import Asked, new_robot

    check_name("robot new: id", name)
    file = Path(f"{name}.yaml")
    if file.exists():
        raise ConfigError(f"robot new: {file} exists already; move it, or choose another id")
    with ends_like_ctrl_c(), ProgressLine() as line, line.counting() as say:
        drafted = new_robot(Asked(name, mjcf, urdf), say)
    try:
        file.write_text(deployment_text(name, drafted.hal, drafted.missing), encoding="utf-8")
    except OSError as error:
        shutil.rmtree(drafted.folder)
        raise ConfigError(f"robot new: cannot write {file.absolute()}: {error.strerror}") from None
    robot = drafted.robot
    parts = "; ".join(f"{part.name}: {', '.join(part.joints)}" for part in robot.parts)
    echo(f"wrote {drafted.folder} and {file}\n{parts}")
    echo(
        f"{len(robot.to_confirm)} entries of robot.yaml are to be given or confirmed before "
        "hardware: to_confirm"
    )
    for found in singular_homes(robot).values():
        echo(found)
    if drafted.missing:
        first, *more = drafted.missing
        echo(f"hal_mujoco cannot move it yet: {first}")
        if more:
            echo(f"  and {len(more)} more: fairlead robot check {name}")
        echo(f"{file} runs {drafted.hal}, without physics, until then")
    echo(f"next: fairlead robot check {name}; fairlead up {file}")
