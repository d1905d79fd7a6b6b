"""``fairlead robot``: look at robots and compile their gate files."""

from __future__ import annotations

from fairlead_tools.cli import (
    robot_bounds,
    robot_capsules,
    robot_compile,
    robot_distances,
    robot_ls,
    robot_show,
)
from fairlead_tools.cli.group import make_group

group = make_group(
    "robot",
    "List and show robots, what bounds them; fit their capsules, compile their gate files.",
    {
        "ls": robot_ls,
        "show": robot_show,
        "bounds": robot_bounds,
        "capsules": robot_capsules,
        "compile": robot_compile,
        "distances": robot_distances,
    },
)
