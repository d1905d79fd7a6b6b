"""``fairlead skill``: look at skills and check them against a robot."""

from __future__ import annotations

from fairlead_tools.cli import skill_check, skill_install, skill_ls, skill_new, skill_show
from fairlead_tools.cli.group import make_group

group = make_group(
    "skill",
    "List, show and check skills, write a new one, install it.",
    {
        "ls": skill_ls,
        "show": skill_show,
        "check": skill_check,
        "new": skill_new,
        "install": skill_install,
    },
)
