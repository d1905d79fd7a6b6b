"""Groups of commands (``fairlead skill ls``): built the same way as the top level."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType

import typer

EXIT_CODES = "Exit codes: 0 it worked, 1 refused or failed, 2 wrong command line, 130 Ctrl-C."


def add_commands(app: typer.Typer, commands: Mapping[str, ModuleType]) -> None:
    """Add each module's ``command``, with its ``EXAMPLE`` under the help text."""
    for name, module in commands.items():
        app.command(name=name, epilog=f"Example: {module.EXAMPLE}  --  {EXIT_CODES}")(
            module.command
        )


def make_group(name: str, text: str, commands: Mapping[str, ModuleType]) -> typer.Typer:
    """A named group of commands."""
    group = typer.Typer(name=name, help=text, no_args_is_help=True, epilog=EXIT_CODES)
    add_commands(group, commands)
    return group
