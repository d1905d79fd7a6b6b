"""Which skill a command is about: one that ships or was installed, or one being written."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.cli.completion import complete_skill

SkillArgument = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FOLDER",
        autocompletion=complete_skill,
        help="a skill that ships or is installed (fairlead skill ls), or a folder with rskill.yaml",
    ),
]
InstalledSkill = Annotated[
    str, typer.Argument(help="a skill of: fairlead skill ls", autocompletion=complete_skill)
]
