"""Which skill a command is about: one that ships or was installed, or one being written."""

from __future__ import annotations

from typing import Annotated

import typer

SkillArgument = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FOLDER",
        help="a skill that ships or is installed (fairlead skill ls), or a folder with rskill.yaml",
    ),
]
