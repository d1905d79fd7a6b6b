"""Robots as somebody might bring them, drafted in the test's own process."""

from __future__ import annotations

import re

from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.draft.new_robot import Asked, new_robot
from tests.draft.drafting import EXAMPLE, Desk


def straight_arm() -> str:
    """The example's MJCF without fingers and without a home: it stands straight up."""
    return re.sub(r" *<keyframe>.*</keyframe>\n", "", without_gripper(), flags=re.S)


def without_gripper() -> str:
    """The example's MJCF without its fingers."""
    text = re.sub(r' *<body name="\w+_finger".*?</body>\n', "", EXAMPLE.read_text(), flags=re.S)
    text = re.sub(r' *<position joint="\w+_finger".*\n', "", text)
    return text.replace(" 0.03 -0.03", "")


def drafted(desk: Desk, name: str, text: str) -> RobotManifest:
    """The robot that `robot new` makes of an MJCF or a URDF."""
    is_mjcf = text.lstrip().startswith(("<!--", "<mujoco"))
    file = desk.write(f"{name}.{'xml' if is_mjcf else 'urdf'}", text)
    new_robot(Asked(name, *((file, None) if is_mjcf else (None, file))), lambda _: None)
    return load_robot(name)


def slow_scara(lower_m: float) -> str:
    """A URDF: the joint before the last slides 0.06 m at 0.1 m/s; its home is 0. None is fast."""
    lift = f'lower="{lower_m}" upper="{lower_m + 0.06}" velocity="0.1"'
    joints = [
        ("pan", "base", "upper", "0 0 0.3", "revolute", 'lower="-2" upper="2" velocity="0.3"'),
        ("bend", "upper", "lower", "0.3 0 0", "revolute", 'lower="-2" upper="2" velocity="0.4"'),
        ("lift", "lower", "quill", "0.3 0 0", "prismatic", lift),
        ("roll", "quill", "flange", "0 0 0.2", "continuous", 'velocity="2"'),
    ]
    box = '<collision><geometry><box size="0.04 0.04 0.04"/></geometry></collision>'
    links = "".join(
        f'<link name="{one}">{box}</link>' for one in ("base", *(joint[2] for joint in joints))
    )
    return f'<robot name="scara">{links}' + "".join(
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place}"/><axis xyz="0 0 1"/><limit {limit} effort="20"/></joint>'
        for name, parent, child, place, kind, limit in joints
    ) + "</robot>"  # fmt: skip
