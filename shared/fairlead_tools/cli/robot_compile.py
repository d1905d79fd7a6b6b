"""``fairlead robot compile``: robot.yaml to the one file the gate loads."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.robot_choice import RobotArgument

EXAMPLE = "fairlead robot compile panda_mobile"


def command(
    robot: RobotArgument,
    check: Annotated[
        bool, typer.Option("--check", help="write nothing; exit 1 if a file is not current")
    ] = False,
) -> None:
    """Compile robot.yaml into gate.PROFILE.json, one file for each safety profile.

    Where robot.yaml names a simulator's model, or ROBOT.xml lies beside it, its frames are
    compared with the description's first.
    """
    manifest = load_robot(robot)
    from fairlead_tools.shape.robot_model import robot_model  # takes long: not for a misspelt name

    model = robot_model(manifest, None, "robot compile")
    if model is not None:
        echo(model.check())
    stale = []
    for profile in manifest.safety:
        path = robot_dir(robot) / f"gate.{profile}.json"
        text = compile_gate_config(manifest, profile)
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            echo(f"{path} is current")
        elif check:
            stale.append(path)
        else:
            _write(path, text)
    for path in stale:
        echo(f"ERROR {path} is not current; fix: fairlead robot compile {robot}", err=True)
    if stale:
        raise typer.Exit(1)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"robot compile: cannot write {path}: {error.strerror}") from None
    echo(f"wrote {path}")
