"""``fairlead skill install``: a checked copy in the user's own skills."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.skill.manifest import read_skill
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.policy_problems import policy_problems
from fairlead_tools.skills.install import install_skill

EXAMPLE = "fairlead skill install my-wave"


def command(
    path: Annotated[
        Path, typer.Argument(exists=True, file_okay=False, help="folder that holds rskill.yaml")
    ],
    force: Annotated[
        bool, typer.Option("--force", help="replace another version of the skill")
    ] = False,
    link: Annotated[
        bool, typer.Option("--link", help="a link to the folder: its edits need no new install")
    ] = False,
) -> None:
    """Check a skill, with every reason if it does not fit, and copy it to the user's skills.

    They are in $FAIRLEAD_SKILLS, else ~/.local/share/fairlead/rskills. A runner offers it at its
    next goal.
    """
    target = install_skill(path, force, policy_problems(read_skill(path)), link)
    echo(f"installed {target}" + (f" -> {target.resolve()}" if link else ""))
    echo(f"next: fairlead run {target.name}")
