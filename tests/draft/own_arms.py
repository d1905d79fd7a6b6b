"""Robots as somebody might bring them, drafted in the test's own process."""

from __future__ import annotations

import re

from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.draft.new_robot import Asked, new_robot
from tests.draft.drafting import EXAMPLE, Desk


def without_gripper() -> str:
    """The example's MJCF without its fingers."""
    text = re.sub(r' *<body name="\w+_finger".*?</body>\n', "", EXAMPLE.read_text(), flags=re.S)
    text = re.sub(r' *<position joint="\w+_finger".*\n', "", text)
    return text.replace(" 0.03 -0.03", "")


def drafted(desk: Desk, name: str, text: str) -> RobotManifest:
    """The robot that `robot new` makes of an MJCF."""
    new_robot(Asked(name, desk.write(f"{name}.xml", text), None), lambda _: None)
    return load_robot(name)
