"""``fairlead robot``: look at robots and compile their gate files."""

from __future__ import annotations

from fairlead.cli import robot_compile, robot_show
from fairlead.cli.group import make_group

group = make_group(
    "robot",
    "Show robots and compile their gate files.",
    {"show": robot_show, "compile": robot_compile},
)
