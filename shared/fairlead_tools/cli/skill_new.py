"""``fairlead skill new``: a folder with a skill that already works."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.robot_choice import RobotOption
from fairlead_tools.skills.skeleton import skill_skeleton

EXAMPLE = "fairlead skill new my-wave --robot panda_mobile"


def command(
    name: Annotated[str, typer.Argument(help="the skill's id, and the folder made here")],
    robot: RobotOption = "panda_mobile",
) -> None:
    """Write NAME/rskill.yaml and NAME/policy.py, a working skill to start from."""
    files = skill_skeleton(name, load_robot(robot))
    folder = Path(name)
    if folder.exists():
        raise ConfigError(f"skill new: {folder} exists already; choose another name")
    try:
        folder.mkdir()
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")
            echo(f"wrote {folder / file}")
    except OSError as error:
        raise ConfigError(
            f"skill new: cannot write {folder.absolute()}: {error.strerror}"
        ) from None
    echo(f"next: fairlead skill install {folder}")
