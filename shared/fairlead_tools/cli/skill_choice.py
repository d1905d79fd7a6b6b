"""Which skill a command is about: one that ships or was installed, or one being written."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.paths import user_skills_dir
from fairlead.skill.manifest import find_skill, read_skill, skill_ids
from fairlead_tools.cli.completion import complete_skill
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.policy_problems import policy_problems
from fairlead_tools.skills.install import install_skill, is_link_to

SkillArgument = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FOLDER",
        autocompletion=complete_skill,
        help="a skill that ships or is installed (fairlead skill ls), or a folder with rskill.yaml",
    ),
]


def installed_skill(wanted: str) -> str:
    """The id of a skill that a person means; a folder is linked into the user's skills, and said.

    Raises:
        ConfigError: there is none, it does not fit, or another one of its name is installed.
    """
    if wanted in skill_ids():
        return wanted
    folder = find_skill(wanted)
    skill = read_skill(folder)
    target = user_skills_dir() / skill.id
    if not is_link_to(target, folder):
        if target.exists():
            raise ConfigError(
                f"skill {skill.id}: another one is installed in {target}; replace it by this one "
                f"with: fairlead skill install --link --force {wanted}"
            )
        install_skill(folder, found=policy_problems(skill), link=True)
        echo(f"linked {target} -> {folder.resolve()}", err=True)
    return skill.id
