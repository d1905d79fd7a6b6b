"""Which robot a command is about: one that ships, or the user's own."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead_tools.cli.completion import complete_robot

_HELP = "folder under robots/"
RobotArgument = Annotated[str, typer.Argument(help=_HELP, autocompletion=complete_robot)]
RobotOption = Annotated[str, typer.Option(help=_HELP, autocompletion=complete_robot)]
