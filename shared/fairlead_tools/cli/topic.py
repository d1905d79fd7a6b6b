"""``fairlead topic``: look on at what the services publish."""

from __future__ import annotations

from fairlead_tools.cli import topic_echo, topic_hz, topic_list
from fairlead_tools.cli.group import make_group

group = make_group(
    "topic",
    "List, decode and time what a running robot's services publish.",
    {"list": topic_list, "echo": topic_echo, "hz": topic_hz},
)
